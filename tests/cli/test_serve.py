"""The command `percuss serve` with a study to begin with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from percuss.cli import app
from percuss.studies import load_study, template_text
from percuss.studies.link import link_of
from percuss.web import app as app_module
from percuss.web import serve as serve_module


@pytest.fixture(autouse=True)
def served(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The link and the sockets served, by a server that ends at once."""
    found: list[Any] = []

    class Ended:
        def run(self, sockets: list[Any]) -> None:
            found.extend(sockets)

    def create_app(**given: Any) -> None:
        found.append(given["link"])

    monkeypatch.setattr(app_module, "create_app", create_app)
    monkeypatch.setattr(serve_module, "server_of", lambda _: Ended())
    return found


def serve(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["serve", "--no-open", "--port", "0", *arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.mark.parametrize("template", ["impact", "diagram", "response", "basins"])
def test_the_address_leads_to_the_study(template: str, served: list[Any]) -> None:
    Path("my.toml").write_text(template_text(template), encoding="utf-8")

    status, out, err = serve("my.toml")

    assert (status, err, len(served)) == (0, "", 2)
    assert "/study (Ctrl-C ends it)" in out
    assert served[0] == link_of(load_study("my.toml"))


def test_without_a_study_the_page_begins_with_its_first_motion(served: list[Any]) -> None:
    status, out, _ = serve()

    assert (status, len(served)) == (0, 2)
    assert "study" not in out


def test_a_file_that_is_none_or_not_shown_is_told_before_anything_is_served(
    served: list[Any],
) -> None:
    Path("orbit.toml").write_text(template_text("orbit"), encoding="utf-8")
    Path("bad.toml").write_text("[oscillator]\ndampnig = 1\n", encoding="utf-8")

    absent, orbit, bad = (serve(name) for name in ("absent.toml", "orbit.toml", "bad.toml"))

    assert [absent[0], orbit[0], bad[0]] == [2, 2, 2]
    assert absent[2].splitlines()[0].startswith("absent.toml: ")
    assert orbit[2] == (
        "study.kind = 'orbit': not on the page, which shows a motion, a diagram, a response, "
        "a sweep, basins, a fit or a design\n"
    )
    assert any(line.startswith("bad.toml:2: oscillator.dampnig") for line in bad[2].splitlines())
    assert served == []
