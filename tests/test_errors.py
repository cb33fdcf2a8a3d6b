"""Messages stay short, whatever a broken file holds."""

from __future__ import annotations

import numpy as np

from geodem.errors import LONGEST, InputError


def test_a_long_message_keeps_its_beginning_and_its_end():
    error = InputError("k" * 5000, "wrong " + "x" * 5000, "Write it so: " + "y" * 5000 + " end")
    text = str(error)
    assert len(text) < 3 * LONGEST + 20
    assert text.startswith("kkk")
    assert ": wrong xxx" in text
    assert "Write it so: yyy" in text
    assert text.endswith(" end.")
    assert error.place == "k" * 5000


def test_an_array_is_told_as_a_list():
    error = InputError(
        "section.line", "a point stands twice", "Take it away", value=np.array([[2.0, 10.0], [2.0, 10.0]])
    )
    assert str(error) == "section.line = [[2.0, 10.0], [2.0, 10.0]]: a point stands twice. Take it away."


def test_a_message_of_usual_length_is_whole():
    error = InputError("material.soil.cohesion", "w" * 300, "r" * 300, value="10 m")
    assert str(error) == f"material.soil.cohesion = '10 m': {'w' * 300}. {'r' * 300}."
