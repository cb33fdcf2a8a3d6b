"""Reading a law's module: what is wrong with a law or with its parameters is said by name."""

import importlib.util
import itertools
from pathlib import Path

import numpy as np
import pytest

from geodem.errors import InputError, InputErrors
from geodem.laws import BOND_LAWS, CONTACT_LAWS
from geodem.laws.contact import linear_frictional
from geodem.laws.protocol import (
    argument_names,
    check_law,
    constants,
    history_arguments,
    history_names,
    in_dimension,
    make_parameters,
)

LINEAR = {"normal_stiffness": 2e6, "shear_stiffness": 1e6, "friction_coefficient": 0.5}
_numbers = itertools.count()


@pytest.fixture
def edited(tmp_path):
    """Make a law from another one's file with some of its text replaced."""

    def make(law, *replacements):
        text = Path(law.__file__).read_text().replace("from ..parameters", "from geodem.laws.parameters")
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / f"edited_law_{next(_numbers)}.py"
        path.write_text(text)
        spec = importlib.util.spec_from_file_location(path.stem, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return make


def test_history_in_the_plane_and_in_space():
    """Order: SCALAR, TANGENTIAL with x, y, z, AXIAL; the plane keeps one component and nothing about the normal."""
    incremental, parallel = CONTACT_LAWS["linear_incremental"], BOND_LAWS["parallel_bond"]
    assert history_names(incremental, 2) == ("normal", "shear_x")
    assert history_names(incremental, 3) == ("normal", "shear_x", "shear_y", "shear_z")
    assert history_names(parallel, 2) == ("shear_x", "bending_x")
    assert history_names(parallel, 3) == (
        "shear_x", "shear_y", "shear_z", "bending_x", "bending_y", "bending_z", "twisting",
    )  # fmt: skip
    assert history_arguments(parallel) == history_names(parallel, 3)


def test_constants_follow_the_dimension():
    parallel = BOND_LAWS["parallel_bond"]
    assert constants(parallel, 2) == {"SPHERES": False}
    assert constants(parallel, 3) == {"SPHERES": True}
    assert constants(linear_frictional, 3) == {}
    arguments = (1.0, 1.0, 1.0, 0.5, 0.5)
    assert in_dimension(parallel.stiffness, 2)(*arguments)[0] == pytest.approx(1.0)
    assert in_dimension(parallel.stiffness, 3)(*arguments)[0] == pytest.approx(np.pi / 4.0)
    assert argument_names(parallel.stiffness) == (
        "radius_factor", "normal_stiffness", "shear_stiffness", "radius_a", "radius_b",
    )  # fmt: skip


def test_parameters_from_what_a_user_gives():
    made = make_parameters(linear_frictional, {**LINEAR, "shear_viscosity": 1}, "contact.rock")
    assert made == linear_frictional.PARAMETERS(2e6, 1e6, 0.5, 0.0, 1.0)
    assert all(type(value) is float for value in made)


@pytest.mark.parametrize(
    ("change", "place", "words"),
    [
        ({"normal_stifness": 1.0}, "contact.rock.normal_stifness", 'Did you mean "normal_stiffness"'),
        ({"Shear-Viscosity": 1.0}, "contact.rock.Shear-Viscosity", 'Did you mean "shear_viscosity"'),
        ({"colour": 1.0}, "contact.rock.colour", 'It takes "normal_stiffness", "shear_stiffness"'),
        ({"shear_stiffness": None}, "contact.rock.shear_stiffness", 'law "linear_frictional" needs it'),
        ({"shear_stiffness": 0.0}, "contact.rock.shear_stiffness = 0.0", "greater than 0"),
        ({"friction_coefficient": -0.1}, "contact.rock.friction_coefficient = -0.1", "not be negative"),
        ({"normal_stiffness": np.nan}, "contact.rock.normal_stiffness = nan", "finite"),
        ({"normal_stiffness": np.inf}, "contact.rock.normal_stiffness = inf", "finite"),
        ({"normal_stiffness": "stiff"}, "contact.rock.normal_stiffness = 'stiff'", "must be a number"),
        ({"normal_stiffness": True}, "contact.rock.normal_stiffness = True", "must be a number"),
    ],
)
def test_what_is_wrong_with_a_parameter_is_said(change, place, words):
    given = {name: value for name, value in {**LINEAR, **change}.items() if value is not None}
    with pytest.raises(InputError) as caught:
        make_parameters(linear_frictional, given, "contact.rock")
    assert not isinstance(caught.value, InputErrors)
    assert str(caught.value).startswith(place)
    assert words in str(caught.value)


def test_all_wrong_parameters_are_said_at_once():
    given = {"normal_stifness": 2e6, "shear_stiffness": -1.0, "friction_coefficient": "rough"}
    with pytest.raises(InputErrors) as caught:
        make_parameters(linear_frictional, given, "")
    assert [error.place for error in caught.value.errors] == [
        "normal_stifness",
        "normal_stiffness",
        "friction_coefficient",
        "shear_stiffness",
    ]


def test_a_bond_may_be_unbreakable():
    given = {"radius_factor": 1.0, "normal_stiffness": 1e9, "shear_stiffness": 1e9}
    strength = {"tensile_strength": np.inf, "shear_strength": np.inf}
    parallel = BOND_LAWS["parallel_bond"]
    assert make_parameters(parallel, {**given, **strength}, "").tensile_strength == np.inf
    with pytest.raises(InputError, match="finite"):
        make_parameters(parallel, {**given, **strength, "shear_strength": -np.inf}, "")


LAST = "return normal, x, y, z, x, y, z"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("def energy(", "def stored_energy(", 'does not offer "energy"'),
        ("def viscous(", "def dashpot(", 'does not offer "viscous"'),
        ("MOMENT = False", "", 'does not offer "MOMENT"'),
        ("DIMENSIONS = (2, 3)", "DIMENSIONS = (1,)", "DIMENSIONS"),
        ("    overlap, slip_x, slip_y", "    overlaps, slip_x, slip_y", 'Did you mean "overlap"'),
        ("    overlap, slip_x, slip_y", "    scale, overlap, slip_x, slip_y", 'asks for "scale"'),
        ("slip_z, time_step,", "slip_z, time_step, scale,", 'viscous: asks for "scale"'),
        ("def stiffness(normal", "def stiffness(slip_x, normal", 'stiffness: asks for "slip_x"'),
        ('TANGENTIAL = ("shear",)', 'TANGENTIAL = ("sliding",)', "does not begin with the shear force"),
        ("SCALAR: tuple[str, ...] = ()", 'SCALAR = ("overlap",)', '"overlap" stands for two things'),
        (LAST, "return normal, x, y, z, x, y", "flat tuple of 7"),
        (LAST, "return [normal, x, y, z, x, y, z]", "flat tuple of 7"),
        (LAST, f"if normal > 0.0:\n        {LAST}\n    {LAST}", "returns at several places"),
        ("keep = limit /", "keep = STRENGTH * limit /", 'uses "STRENGTH"'),
        ("keep = limit /", "keep = min(limit, 1e9) /", 'uses "min"'),
    ],
)
def test_what_is_wrong_with_a_law_is_said(edited, old, new, words):
    law = edited(linear_frictional, (old, new))
    with pytest.raises(InputError) as caught:
        check_law(law, "contact")
    assert str(caught.value).startswith("contact law linear_frictional")
    assert words in str(caught.value)


def test_a_bond_must_say_whether_it_replaces_the_contact(edited):
    law = edited(BOND_LAWS["two_springs"], ("REPLACES_CONTACT = True", ""))
    with pytest.raises(InputError, match="REPLACES_CONTACT"):
        check_law(law, "bond")


def test_an_unedited_copy_is_a_law(edited):
    law = edited(
        linear_frictional, ("keep = limit /", "keep = HALF * limit /"), ("MOMENT =", "HALF = 0.5\nMOMENT =")
    )
    check_law(law, "contact")
    assert constants(law, 3) == {"HALF": 0.5}
