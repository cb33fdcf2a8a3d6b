"""The beginning of every case: its workflow, its title and the values that it says are meant."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputErrors
from ..kinds import KINDS
from .document import check_allowed, parse_document, read_allowed, refuse_other
from .table import Findings, Table, listed, quoted


class CaseHead(NamedTuple):
    """A case of which the beginning has been read.

    Attributes
    ----------
    text : str
    document : dict
    top : Table
        Of the whole file.
    title : str
    """

    text: str
    document: dict[str, Any]
    top: Table
    title: str

    @property
    def findings(self) -> Findings:
        """Errors and notices of the whole file."""
        return self.top.findings

    def seed(self, default: int = 1) -> int:
        """The key `seed` of the case."""
        found = self.top.integer("seed", smallest=0, remedy="Write a whole number such as 1.")
        if "seed" not in self.top:
            self.findings.default("seed", str(default))
        return default if found is None else found

    def close(self) -> dict[str, Any]:
        """Raise InputErrors with all that is wrong in the file, in its order; else what every case has in common.

        Called when everything else has been read. The entries are those of a case's class: title,
        allow_implausible, notices, questions and text.
        """
        findings = self.findings
        check_allowed(findings, self.document)
        if findings.errors:
            raise InputErrors(findings.in_order())
        return {
            "title": self.title,
            "allow_implausible": findings.allowed,
            "notices": tuple(findings.notices),
            "questions": tuple(findings.questions),
            "text": self.text,
        }


def read_head(text: str, folder: Path, workflow: str, keys: tuple[str, ...], *, example: str) -> CaseHead:
    """Read the beginning of a case.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        Of the case; its name is the title where none is given.
    workflow : str
        The kind that it must be.
    keys : tuple of str
        The top-level keys that it may have; "workflow", "title" and "allow_implausible" among them.
    example : str
        A title, for the remedy.

    Raises
    ------
    InputError
        The text is no TOML, or a case of another kind.
    """
    document = parse_document(text)
    refuse_other(document, workflow)
    findings = Findings(document)
    top = Table(findings, "", document, keys)
    read_allowed(top)
    if "workflow" not in top:
        top.missing("workflow", f'Write workflow = "{workflow}". Known: {listed(KINDS)}.')
    else:
        top.choice("workflow", tuple(KINDS))
    title = top.text("title", remedy=f"Write title = {quoted(example)}.")
    if "title" not in top:
        title = folder.resolve().name or workflow.capitalize()
        findings.default("title", quoted(title))
    return CaseHead(text, document, top, title or "")
