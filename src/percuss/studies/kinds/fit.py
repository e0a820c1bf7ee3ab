"""Studies of a fit: the parameters of a model from measurements of its motion."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import BeforeValidator, Field, PlainSerializer, PlainValidator, TypeAdapter
from pydantic_core import PydanticCustomError

from percuss.execution import Execution
from percuss.fitting import fit
from percuss.fitting.losses import LossName
from percuss.fitting.measured import quantity_dimensions
from percuss.fitting.noise import NOT_WHITE
from percuss.fitting.plausibility import beyond_force
from percuss.fitting.result import with_error
from percuss.io.study_text import number, start_table
from percuss.model.dimensions import unit_of_setting
from percuss.model.exact import Exact, Phase, as_float, number_problem
from percuss.model.paths import long_form
from percuss.model.start import Start
from percuss.model.structure_start import StructureStart
from percuss.model.units import in_units, is_unit
from percuss.studies.axes import ParameterRange, guesses_in
from percuss.studies.fit_records import FitRecord, fit_records, written_record
from percuss.studies.study import Picture, Question, StudyDraft, check_start
from percuss.studies.tables import (
    Path,
    StartState,
    Text,
    default,
    raw_table,
    shown,
    table,
    table_only,
)
from percuss.wording import counted

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.fitting import Fit as FitResult
    from percuss.studies.study import Study

NO_PRIOR = "not [mean, standard deviation], the latter above 0"
# Residuals far below the noise that was given.
FAR_TOO_SMALL = 0.01


def _rows(value: object) -> object:
    if not isinstance(value, list | tuple):
        raise PydanticCustomError("records", "not a list; begin each record with [[fit.records]]")
    return tuple(value)


def _written_free(free: Any) -> object:
    return {
        path: [number(end) for end in given] if isinstance(given, tuple) else number(given)
        for path, given in free.items()
    }


def _known_start(value: object) -> object:
    return None if value is None else TypeAdapter(StartState).validate_python(value)


def _as_list(value: object) -> object:
    return (value,) if isinstance(value, str) else value


FreeKeys = Annotated[
    dict[str, Phase | ParameterRange],
    PlainValidator(table_only),
    PlainSerializer(_written_free),
]
PriorKeys = Annotated[
    dict[str, tuple[Exact, Exact]],
    PlainValidator(table_only),
    PlainSerializer(lambda prior: _written_free(prior) or None),
]
RecordRows = Annotated[
    tuple[FitRecord, ...],
    PlainValidator(_rows),
    PlainSerializer(lambda records: [written_record(record) for record in records]),
]
KnownStart = Annotated[
    Start | StructureStart | None,
    PlainValidator(_known_start),
    PlainSerializer(lambda start: None if start is None else start_table(start)),
]
Profiles = Annotated[
    tuple[Text, ...], BeforeValidator(_as_list), PlainSerializer(lambda paths: list(paths) or None)
]
Scale = Annotated[float, Field(gt=0, allow_inf_nan=False)]


@table
class Fit(Question):
    """Parameters from records, as `percuss.fit` takes them.

    Parameters
    ----------
    records
        What was measured.
    free
        The free parameters by their paths: guesses, or ranges.
    prior
        Mean and standard deviation of what was known of parameters before.
    loss, loss_scale
        As there.
    profiles
        Paths of the parameters whose profile likelihoods are wanted.
    start
        The start of all records; None: unknown.
    """

    doing: ClassVar = "fitting"
    takes_store: ClassVar = True
    needed: ClassVar = ("fit",)
    needed_of_structures: ClassVar = ("fit",)
    save_keys: ClassVar = ("samples",)
    draw_keys: ClassVar = ("window",)

    records: RecordRows = ()
    free: FreeKeys = Field(default_factory=dict)
    prior: PriorKeys = Field(default_factory=dict)
    loss: LossName = default(fit, "loss")
    loss_scale: Scale = default(fit, "loss_scale")
    profiles: Profiles = ()
    start: KnownStart = None

    def checked(self, study: StudyDraft) -> Self:
        """Read the records and what is free, and check them against the model."""
        known = self.start
        if known is not None and study.structure is not None:
            from percuss.studies.of_structures import checked_start

            known = checked_start(known, study)
        elif known is not None:
            check_start(known, study)  # type: ignore[arg-type]
        start = None if study.faults.is_wrong("start") else known
        records = fit_records(self.records, start, study)
        free = guesses_in(study, ("fit", "free"), start)
        own = raw_table(study.document, "fit")
        if not raw_table(own, "free") and not study.faults.is_wrong("fit.free"):
            study.faults.add(("fit", "free"), 'missing; such as {"oscillator.damping" = "0.1"}')
        prior = self._prior(free, study)
        self._check_profiles(free, study)
        self._check_window(study)
        if not study.faults.faults:
            _check_count(records, len(free), start, study)
        return replace(self, records=tuple(records), free=free, prior=prior, start=known)

    def _prior(self, free: dict[str, Any], study: StudyDraft) -> dict[str, tuple[Exact, Exact]]:
        """Return the priors, and add their faults."""
        prior: dict[str, tuple[Exact, Exact]] = {}
        for path, given in self.prior.items():
            place: Path = ("fit", "prior", path)
            if path not in free:
                if _is_known(free, study):
                    study.faults.add(place, f"none of the free parameters: {', '.join(free)}")
                continue
            # Not checked before the model is known.
            pair: Any = given
            is_pair = isinstance(pair, list | tuple) and len(pair) == 2
            if not is_pair or any(
                isinstance(value, bool) or number_problem(value) is not None for value in pair
            ):
                study.faults.add(place, NO_PRIOR, shown(given))
            elif not as_float(given[1]) > 0.0:
                study.faults.add((*place, 1), NO_PRIOR, shown(given[1]))
            else:
                prior[path] = given[0], given[1]
        return prior

    def _check_profiles(self, free: dict[str, Any], study: StudyDraft) -> None:
        """Add the faults of profiles of what is not free."""
        for index, path in enumerate(self.profiles):
            if path not in free and _is_known(free, study):
                reason = f"none of the free parameters: {', '.join(free)}"
                study.faults.add(("fit", "profiles", index), reason, shown(path))

    def _check_window(self, study: StudyDraft) -> None:
        """Add the fault of a part that is drawn and is none."""
        window = study.draw.window
        if window is None or study.faults.is_wrong("draw.window"):
            return
        if as_float(window[0]) >= as_float(window[1]):
            reason = "the first time is not before the last"
            study.faults.add(("draw", "window"), reason, shown(list(window)))

    def answer(self, study: Study, execution: Execution) -> FitResult:
        """Fit, and follow the profiles."""
        model, force = study.model, study.force
        records = self.records
        starts = [record.start or self.start or "free" for record in records]
        report, goes_on = execution.progress, True

        def advance(done: float, total: float) -> bool:
            nonlocal goes_on
            goes_on = goes_on and (not callable(report) or report(done, total) is not False)
            return goes_on

        result = fit(
            [_dataset(record) for record in records],
            model,
            [record.forcing(model, force) for record in records],
            free={path: _as_floats(given) for path, given in self.free.items()},
            start=starts if any(start != "free" for start in starts) else "free",
            prior=self.prior,
            loss=self.loss,
            loss_scale=self.loss_scale,
            store=execution.store,
            progress=advance if callable(report) else report,
        )
        for path in self.profiles:
            name = long_form(path, result.oscillator, result.forcing, result.start)
            # A search that was stopped is at no least misfit to grow from.
            if goes_on and 0.0 < result.errors[name] < math.inf:
                result.profile(path)
        return result

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return the tables: parameters, what their errors share, residuals, impacts."""
        own = {"profiles": "profiles"} if self.profiles else {}
        names = {"covariance": "covariance", "residuals": "residuals", "impacts": "impacts"}
        return {"fit": "parameters", **names, **own}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return what draws each quantity with the fit, pairs of parameters, and the profiles."""
        measured = [name for name in self.records[0].data if name not in ("t", "noise")]
        more = {f"fit_{name}": partial(self.draw, quantity=name) for name in measured[1:]}
        pairs = {"confidence": self.draw_confidence} if len(self.free) > 2 else {}
        own = {"profiles": self.draw_profiles} if self.profiles else {}
        return {"fit": self.draw, **more, **pairs, **own}

    def draw(self, result: Any, study: Study, figure: Any, quantity: str | None = None) -> None:
        """Draw record, fit, residuals and what two parameters share."""
        from percuss.plotting import plot_fit

        figure.set_size_inches(10.0 if len(result.values) > 1 else 7.0, 5.8)
        window = study.draw.window
        ends = None if window is None else (as_float(window[0]), as_float(window[1]))
        plot_fit(result, figure, quantity=quantity, window=ends, units=study.draw.units())

    def draw_confidence(self, result: Any, study: Study, figure: Any) -> None:
        """Draw what each pair of parameters shares."""
        from percuss.plotting import plot_confidence

        n = sum(0.0 < error < math.inf for error in result.errors.values()) - 1
        if n > 0:
            figure.set_size_inches(1.4 + 2.4 * n, 1.2 + 2.2 * n)
            plot_confidence(result, figure, units=study.draw.units())
        else:
            figure.text(0.5, 0.5, "fewer than two parameters have errors", ha="center")

    def draw_profiles(self, result: Any, study: Study, figure: Any) -> None:
        """Draw the profile likelihoods."""
        from percuss.plotting import plot_profiles

        figure.set_size_inches(0.6 + 3.4 * max(1, len(result.profiles)), 3.9)
        if result.profiles:
            plot_profiles(result, figure, units=study.draw.units())
        else:
            figure.text(0.5, 0.5, "none of the parameters asked for has an error", ha="center")

    def report(self, result: Any) -> dict[str, str]:
        """Return the parameters with their errors, and how well they explain the records."""
        end = "converged" if result.converged else f"not converged: {result.reason}"
        rows = {"fit": f"{end}; {counted(result.n_runs, 'run')} of the record"}
        beyond = beyond_force([layout.record for layout in result.problem.layouts])
        rows |= {"record": beyond} if beyond and result.converged else {}
        # By the names of the file.
        own = dict(zip(result.values, self.free, strict=True))
        for path, value in result.values.items():
            rows[own[path]] = _value_in_words(result, path, value)
        for i, direction in enumerate(result.unidentifiable):
            along = ", ".join(f"{share:+.2g} {own[path]}" for path, share in direction.items())
            rows["not told by the data" + (f" ({i})" if i else "")] = along
        count = len(result.residuals.sample)
        judged = _whiteness(result.whiteness)
        if result.chi2 < FAR_TOO_SMALL:
            times = 1.0 / math.sqrt(max(result.chi2, 1e-300))
            judged = (
                f"the noise that was given is {times:.3g} times theirs: is it in the model's units?"
            )
        rows["residuals"] = f"mean square {result.chi2:.4g} of {count:,} values, {judged}"
        rows["noise"] = ", ".join(
            f"{name} {_noise_in_words(result, name, size)}" for name, size in result.noise.items()
        )
        if result.oscillator.stops:
            rows["impacts"] = _impacts_in_words(result.impacts)
        for path in result.values:
            if path in result.profiles:
                rows[f"profile of {own[path]}"] = _profile_in_words(result.profiles[path])
            elif own[path] in self.profiles:
                has_error = 0.0 < result.errors[path] < math.inf
                reason = "the search was stopped" if has_error else "it has no error"
                rows[f"profile of {own[path]}"] = f"none, {reason}"
        return rows


def _is_known(free: dict[str, Any], study: StudyDraft) -> bool:
    """Return whether what is free could be read as a whole."""
    return bool(free) and study.has_right_model and not study.faults.is_wrong("fit.free")


def _as_floats(given: Phase | ParameterRange) -> float | tuple[float, float]:
    """Return a guess or a range as floats."""
    if isinstance(given, tuple):
        return as_float(given[0]), as_float(given[1])
    return as_float(given)


def _dataset(record: FitRecord) -> Dataset:
    """Return a record with the noise of each quantity in its attributes."""
    import xarray as xr

    columns = record.columns
    noise = columns.pop("noise", record.deviation)
    t = columns.pop("t", None)
    data = {}
    for name, values in columns.items():
        own = noise.get(name) if isinstance(noise, dict) else noise
        # A dimension of its own name would make it a coordinate.
        dim = "impact" if name == "impact_times" else "sample"
        data[name] = (dim, values, {} if own is None else {"noise": own})
    return xr.Dataset(data, {} if t is None else {"t": ("sample", t)})


def _check_count(
    records: list[FitRecord], n_free: int, start: Start | StructureStart | None, study: StudyDraft
) -> None:
    """Add the fault of fewer values than unknowns."""
    count = sum(
        value is not None
        for record in records
        for name, values in record.data.items()
        if name not in ("t", "noise")
        for value in values
    )
    n_starts = sum(record.start is None and start is None for record in records)
    of_start = 2 if study.structure is None else 2 * study.structure.n
    unknowns = n_free + of_start * n_starts
    if count < unknowns:
        each = "two" if of_start == 2 else f"{of_start}"
        more = f"; a start that is not given has {each}" if n_starts else ""
        reason = f"{counted(count, 'value')} for {counted(unknowns, 'unknown')}{more}"
        study.faults.add(("fit", "records"), reason)


def _value_in_words(result: FitResult, path: str, value: float) -> str:
    """Return a parameter with its error and unit, and what is to be known of it."""
    error = result.errors[path]
    unit = unit_of_setting(path, result.oscillator, result.forcing)
    unit = f" {unit}" if is_unit(unit) else ""
    if end := result.end_of(path):
        change = {"least": "less", "largest": "more"}[end]
        return f"{value:.6g}{unit}, the {end} of its range: the data ask for {change}"
    if math.isinf(error):
        return f"{value:.6g}{unit}, not told by the data"
    return with_error(value, error) + unit


def _noise_in_words(result: FitResult, name: str, size: float) -> str:
    """Return the noise of a quantity with its unit."""
    unit = in_units(result.oscillator.units, quantity_dimensions(name))
    return f"{size:.4g} {unit}" if is_unit(unit) else f"{size:.4g}"


def _whiteness(score: float) -> str:
    return "which hang together: the model misses something" if score < NOT_WHITE else "like noise"


def _impacts_in_words(times: Any) -> str:
    if not len(times):
        return "none in the first record"
    ends = f"t = {times[0]:.6g}" if len(times) == 1 else f"t = {times[0]:.6g} to {times[-1]:.6g}"
    return f"{len(times):,} in the first record, {ends}"


def _profile_in_words(profile: Any) -> str:
    """Return the values between which a profile stays below 1 and 3.84."""
    from percuss.fitting.summaries import interval_of

    if math.isnan(interval_of(profile)[0]):
        return "no motion was found with it"
    words = []
    for level, share in ((1.0, 68), (3.84, 95)):
        low, high = interval_of(profile, level)
        words.append(f"{low:.6g} to {high:.6g} ({share} %)")
    return ", ".join(words)
