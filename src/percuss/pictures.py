"""``result.plot()``: the picture of a result, of which it knows the name only.

Results lie below `percuss.plotting`, which imports them all and matplotlib besides: the function is
looked up when it is called.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, ClassVar


class HasPicture:
    """A result that one function of `percuss.plotting` draws."""

    __slots__ = ()

    picture: ClassVar[str]

    def plot(self, **how: Any) -> Any:
        """Draw the result, as the function of `percuss.plotting` named `picture` does.

        Parameters
        ----------
        **how
            The keywords of that function, such as ``ax``, ``window`` or ``units``.

        Returns
        -------
        Axes, Figure or tuple of these
            As that function returns them.

        Examples
        --------
        >>> import percuss as pc
        >>> run = pc.simulate(pc.impact_oscillator(0.8), pc.cosine(2.5), v0=1.0, t_end=20)
        >>> axes = run.plot(window=(0, 10))
        >>> run.picture
        'plot_motion'
        """
        return getattr(import_module("percuss.plotting"), self.picture)(self, **how)
