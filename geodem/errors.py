"""The errors that geodem raises on purpose; a user sees them as text, never as a traceback."""

from __future__ import annotations

from pathlib import Path

LONGEST = 600
"""Of each part of a message [characters]."""


class InputError(ValueError):
    """Input that cannot be used.

    The message always has the same four parts: where (key, file or place), what stands there, what is wrong,
    and what to do about it.

    Parameters
    ----------
    place : str
        Dotted key of the case file (``material.soil.cohesion``), file name or place in the model.
    problem : str
        What is wrong, in one clause.
    remedy : str
        What the user can do, with an example where that helps.
    value : object, optional
        What was found there.
    picture : pathlib.Path, optional
        A picture that shows where.
    """

    def __init__(
        self, place: str, problem: str, remedy: str, *, value: object = None, picture: Path | None = None
    ) -> None:
        self.place = place
        self.problem = problem
        self.remedy = remedy
        self.value = value
        self.picture = picture
        super().__init__(str(self))

    def __str__(self) -> str:
        # an array as a list: its own text is spread over lines
        value = getattr(self.value, "tolist", lambda: self.value)()
        found = "" if value is None else f" = {value!r}"
        shown = "" if self.picture is None else f" See {self.picture}."
        remedy = self.remedy if self.remedy.endswith((".", "?", ")")) else f"{self.remedy}."
        place, problem, remedy = (_brief(text) for text in (self.place + found, self.problem, remedy))
        return f"{place}: {problem}. {remedy}{shown}"


class InputErrors(InputError):
    """Several input errors found in one pass, so that all can be mended at once.

    Parameters
    ----------
    errors : list of InputError
        In the order of the case file; at least one.
    """

    def __init__(self, errors: list[InputError]) -> None:
        self.errors = errors
        first = errors[0]
        super().__init__(first.place, first.problem, first.remedy, value=first.value, picture=first.picture)

    def __str__(self) -> str:
        return "\n".join(str(error) for error in self.errors)


def _brief(text: str) -> str:
    """Beginning and end of a text that names what a broken file holds, where that is longer than anyone reads."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 100]} ... {text[-95:]}"


class StoppedError(RuntimeError):
    """A run that stopped before its end and can be resumed from its checkpoint (exit status 3)."""


class UnstableError(RuntimeError):
    """A motion that has come to mean nothing: numbers that are none, steps too long, energy out of nothing.

    Parameters
    ----------
    cause : str
        What was found, in one clause about the particle where there is one.
    remedy : str
        What to do.
    step : int
        After which it was found.
    particle : int, optional
        In the order of the user.
    place : tuple of float, optional
        Of the particle [m].
    detail : str
        What else helps to see why.
    last_good : int, optional
        Step of the last good state that is kept.
    """

    def __init__(
        self,
        cause: str,
        remedy: str,
        *,
        step: int,
        particle: int | None = None,
        place: tuple[float, ...] | None = None,
        detail: str = "",
        last_good: int | None = None,
    ) -> None:
        self.cause = cause
        self.remedy = remedy
        self.step = step
        self.particle = particle
        self.place = place
        self.last_good = last_good
        who = "" if particle is None else f", particle {particle}"
        if place is not None:
            who += " at (" + ", ".join(f"{value:.6g}" for value in place) + ") m"
        kept = "" if last_good is None else f" The state at step {last_good:,} is kept: see last_good."
        more = f" ({detail})" if detail else ""
        super().__init__(f"after step {step:,}{who}: {cause}{more}. {remedy}.{kept}")
