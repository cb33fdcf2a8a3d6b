"""Messages stay short, whatever a broken file holds."""

from __future__ import annotations

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


def test_a_message_of_usual_length_is_whole():
    error = InputError("material.soil.cohesion", "w" * 300, "r" * 300, value="10 m")
    assert str(error) == f"material.soil.cohesion = '10 m': {'w' * 300}. {'r' * 300}."
