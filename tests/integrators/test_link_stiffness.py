"""The stiffness of many links: compiled, it is that of the law's plain function."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.integrators import link_stiffness
from geodem.laws import BOND_LAWS, CONTACT_LAWS

LAWS = [
    (law, dimension)
    for laws in (CONTACT_LAWS, BOND_LAWS)
    for law in laws.values()
    for dimension in law.DIMENSIONS
]


@pytest.mark.parametrize(("law", "dimension"), LAWS, ids=[f"{law.NAME}-{d}" for law, d in LAWS])
def test_compiled_is_plain(law, dimension, monkeypatch):
    rng = np.random.default_rng(1)
    parameters = rng.uniform(0.1, 0.4, (50, len(law.PARAMETERS._fields)))
    names = ("radius_a", "radius_b", "distance", "overlap", "mass_a", "mass_b")
    sizes = dict(zip(names, rng.uniform(0.1, 2.0, (6, 50)), strict=True))
    plain = link_stiffness.law_stiffness(law, dimension, parameters, **sizes)
    monkeypatch.setattr(link_stiffness, "COMPILED_FROM", 1)
    compiled = link_stiffness.law_stiffness(law, dimension, parameters, **sizes)
    assert compiled == pytest.approx(plain, rel=1e-14)
    assert (compiled[:, 0] > 0.0).all()
