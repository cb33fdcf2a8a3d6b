"""The report needs nothing outside itself, tells every number, and lets no user text become markup."""

import base64
import dataclasses
import html
import os
import re
import resource
import struct
from functools import cached_property
from html.parser import HTMLParser

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.plotting.report import write_report
from geodem.plotting.wording import powers

VOID = {"meta", "img", "line", "rect", "circle", "br", "link"}


class Reader(HTMLParser):
    """Tags with attributes, visible text, and whether every tag is closed in order."""

    def __init__(self, source):
        super().__init__(convert_charrefs=True)
        self.tags, self.words, self.open, self.skip = [], [], [], 0
        self.feed(source)
        assert not self.open, f"left open: {self.open}"

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.words.append(data)

    @cached_property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.words))


def report(tmp_path, result, view, **changes):
    path = tmp_path / "report.html"
    figures = write_report(path, result, dataclasses.replace(view, **changes))
    source = path.read_text(encoding="utf-8")
    return source, Reader(source), figures


@pytest.fixture(scope="module")
def whole(tmp_path_factory, make_view, make_result):
    folder = tmp_path_factory.mktemp("report")
    return (*report(folder, make_result(), make_view()), folder)


def test_needs_nothing_outside_itself(whole):
    source, page, _, _ = whole
    assert "http://" not in source
    assert "https://" not in source
    assert "@import" not in source
    assert "url(" not in source
    names = {tag for tag, _ in page.tags}
    assert not names & {"script", "link", "iframe", "object", "base"}
    for _, attributes in page.tags:
        assert not any(name.startswith("on") for name in attributes)
        if "src" in attributes:
            assert attributes["src"].startswith("data:image/")
        if "href" in attributes:
            assert attributes["href"].startswith("#")


def test_every_link_leads_somewhere_and_every_picture_is_described(whole):
    _, page, _, _ = whole
    anchors = {attributes["id"] for _, attributes in page.tags if "id" in attributes}
    links = [attributes["href"][1:] for tag, attributes in page.tags if tag == "a"]
    assert len(links) == 9
    assert set(links) <= anchors
    pictures = [attributes for tag, attributes in page.tags if tag == "img"]
    assert len(pictures) == 11
    assert all(picture["alt"] for picture in pictures)


def test_headline_and_verdict(whole):
    _, page, _, _ = whole
    assert "Factor of safety 1.26 (strength reduction; stable at 1.255, failed at 1.267)" in page.text
    assert "The ground stands" in page.text
    assert "Gravity factor 3.29 (gravity increase; stable at 3.270, failed at 3.310)" in page.text
    assert "NOT a factor of safety" in page.text
    assert page.text.index("Factor of safety 1.26") < page.text.index("Gravity factor 3.29")


def test_other_methods_with_differences(whole):
    _, page, _, _ = whole
    # (1.261 - 1.271) / 1.271 = -0.79 %, (1.261 - 1.268) / 1.268 = -0.55 %, (1.261 - 1.26) / 1.26 = +0.08 %
    for method, factor, difference in (
        ("Bishop simplified", "1.271", "\N{MINUS SIGN}0.8 %"),
        ("Spencer", "1.268", "\N{MINUS SIGN}0.6 %"),
        ("Published value", "1.260", "+0.1 %"),
    ):
        assert re.search(rf"{method} {factor} {re.escape(difference)}", page.text), method


def test_all_numbers_are_told(whole, make_result, make_view):
    _, page, _, _ = whole
    view = make_view()
    for method in view.methods:
        for trial in method.trials:
            assert f"{trial['factor']:.4f} {trial['verdict']} {powers(trial['criterion'])}" in page.text
    for row in view.material_rows:
        for name, value in row.items():
            assert value in page.text, name
    for known in (
        "2,513", "21,345", "14.2 s", "0.21 s", "geodem run case.toml --threads 2", "51,234 J/m", "40,001 J/m",
        "0.00210 %", "78.1 %", "20 kPa", "boundary.top was not given: free", "check the thickness", "0.1.0",
        "42,000 circles searched", "quasi-static relaxation", "848.2 m²", "left: roller", "random",
    ):  # fmt: skip
        assert known in page.text, known


def test_case_file_as_it_was_run(whole, make_view):
    source, _, _, _ = whole
    shown = re.search(r'<pre class="case">(.*?)</pre>', source, re.S)
    plain = html.unescape(re.sub(r"</?(b|span)[^>]*>", "", shown.group(1)))
    assert plain == make_view().case_text.rstrip("\n")


def test_pictures_are_whole_and_also_stand_as_files(whole):
    source, page, figures, folder = whole
    assert len(figures) == 11
    assert len(source) < 4_000_000
    for name, picture in figures.items():
        assert (folder / "figures" / f"{name}.png").read_bytes() == picture
        assert picture[:8] == b"\x89PNG\r\n\x1a\n"
        width, height = struct.unpack(">II", picture[16:24])
        assert 600 <= width <= 1100, name
        assert 200 <= height <= 1300, name
    for tag, attributes in page.tags:
        if tag == "img":
            data = base64.b64decode(attributes["src"].split(",", 1)[1], validate=True)
            assert data[:8] == b"\x89PNG\r\n\x1a\n" or data.lstrip().startswith(b"<?xml")


def test_the_same_run_gives_the_same_page(whole, tmp_path, make_view, make_result):
    source, _, _, _ = whole
    assert report(tmp_path, make_result(), make_view())[0] == source


def test_user_text_is_escaped_everywhere(tmp_path, view, result, make_view):
    evil = '<script>alert("x")</script> & <img src=x onerror=y> \'"'
    result["warnings"] = result["notices"] = [evil]
    result["neighbours"][0] |= {"method": evil, "notes": [evil]}
    result["reference"]["source"] = result["command"] = evil
    result["neighbours_why"] = evil
    result["versions"] = {evil: evil}
    result["settings"] = {evil: evil}
    result["energy"] = {evil: evil, "external_work": 1.0}
    result["factors"][0]["criterion"] = evil
    trial = {**view.methods[0].trials[0], "criterion": evil, "model": "fine"}
    method = dataclasses.replace(view.methods[0], trials=[trial], failure=None, histories=[])
    source, page, _ = report(
        tmp_path,
        result,
        view,
        title=evil,
        case_text=f"# {evil}\n[{evil}]\nkey = '{evil}'",
        materials=("a & b", "<b>"),
        outlines=(),
        material_rows=[{"name": evil, evil: evil}],
        supports={"left": evil},
        loads=evil,
        methods=[method],
    )
    assert "<script" not in source
    assert "onerror=y>" not in source
    assert not any(tag == "script" or "onerror" in attributes for tag, attributes in page.tags)
    assert page.text.count('<script>alert("x")</script>') > 15


def test_without_neighbours_the_reason_stands(tmp_path, view, result):
    result["neighbours"], result["neighbours_why"] = [], "two materials meet <here>"
    del result["reference"]
    _, page, _ = report(tmp_path, result, view, methods=[])
    assert "No limit equilibrium beside it: two materials meet <here>" in page.text
    assert "Bishop simplified" not in page.text


def test_energy_with_units_in_its_keys(tmp_path, view, result):
    result["energy"] = {
        "factor": 1.2906,
        "external_work_J_per_m": 81267.0,
        "plastic_J_per_m": 79840.6,
        "closure": -2.5e-7,
    }
    result["spacing_m"] = 0.502
    _, page, _ = report(tmp_path, result, view, methods=[])
    assert "factor 1.291" in page.text
    assert "external work 81,267 J/m 100.0 %" in page.text
    assert "plastic 79,841 J/m 98.2 %" in page.text  # 79840.6 / 81267
    assert "closure error -2.5·10⁻⁵ %" in page.text
    assert "Spacing [m] 0.502" in page.text
    assert "J per m" not in page.text


def test_a_reference_that_repeats_a_value_is_listed_once(tmp_path, view, result):
    result["factors"][0]["reference"] = {
        "value": 1.271,
        "how": "Bishop simplified",
        "difference_percent": -0.8,
    }
    _, page, _ = report(tmp_path, result, view, methods=[])
    head = page.text[: page.text.index("Gravity factor")]
    assert head.count("1.271") == 1
    assert head.count("Published value") == 1


def test_circles_that_miss_a_weak_layer_are_explained(tmp_path, view, result):
    _, page, _ = report(tmp_path, result, view, methods=[])
    assert "a circle cannot follow a weak layer" not in page.text
    for neighbour in result["neighbours"]:
        neighbour["factor"] = 1.52
    _, page, _ = report(tmp_path, result, view, methods=[])
    assert "a circle cannot follow a weak layer" in page.text


def test_without_anything_optional(tmp_path, view):
    bare = {"factors": [{"kind": "strength-reduction", "value": 1.0, "stable": 0.995, "failed": 1.005}]}
    _, page, figures = report(
        tmp_path, bare, view, methods=[], material_rows=[], outlines=[], supports={}, loads=(), case_text="",
        surcharges=(), spacing=None,
    )  # fmt: skip
    assert "Factor of safety 1.00 (strength reduction; stable at 0.995, failed at 1.005)" in page.text
    assert "at its limit" in page.text
    assert list(figures) == ["particles"]


def test_no_failed_state(tmp_path, view, result):
    methods = [dataclasses.replace(view.methods[0], value=None, failed=None, failure=None)]
    result["factors"] = [{"kind": "strength-reduction", "value": None, "stable": 5.0, "failed": None}]
    _, page, figures = report(tmp_path, result, view, methods=methods)
    assert "Factor of safety above 5.000" in page.text
    assert "no failed state to show" in page.text
    assert "strength-failure" not in figures


def test_failure_in_which_nothing_parts(tmp_path, view, result, make_method):
    from geodem.measure.failure import describe_failure

    still = np.zeros_like(view.positions)
    state = describe_failure(view.positions, view.triangles, still, still[:, 0])
    methods = [dataclasses.replace(view.methods[0], failure=state, trials=[], histories=[])]
    _, page, figures = report(tmp_path, result, view, methods=methods)
    assert "No mass parts from the rest" in page.text
    assert "strength-failure" in figures


def test_undecided_trials_are_told_and_never_counted_as_stable(tmp_path, view, result):
    method = view.methods[0]
    undecided = {
        **method.trials[0],
        "factor": 1.2611,
        "verdict": "undecided",
        "criterion": "neither at rest nor growing",
    }
    history = (1.2611, "undecided", np.arange(5.0), np.arange(5.0))
    methods = [
        dataclasses.replace(
            method,
            failure=None,
            undecided=[1.2611, 1.2589],
            trials=[*method.trials, undecided],
            histories=[*method.histories, history],
        )
    ]
    result["factors"] = result["factors"][:1]
    _, page, _ = report(tmp_path, result, view, methods=methods)
    assert "2 trials were undecided in the strength reduction, at 1.259, 1.261" in page.text
    assert "neither stable nor failed" in page.text
    assert "stable at 1.255" in page.text


def test_gravity_alone_is_never_called_factor_of_safety(tmp_path, view, result):
    result["factors"] = result["factors"][1:]
    _, page, _ = report(
        tmp_path, result, view, methods=[dataclasses.replace(view.methods[1], failure=None, histories=[])]
    )
    head = page.text[: page.text.index("How it fails")]
    assert "Gravity factor 3.29 (gravity increase; stable at 3.270, failed at 3.310)" in head
    assert "NOT a factor of safety" in head
    assert "Bishop" not in head  # a load factor does not compare with a factor of safety


def test_source_picture_stands_beside_the_particles(tmp_path, view, result):
    from PIL import Image

    picture = tmp_path / "my section.png"
    Image.new("RGB", (3000, 1000), "#8c6d31").save(picture)
    _, page, _ = report(tmp_path, result, view, methods=[], image_path=picture)
    assert "As given: my section.png" in page.text
    assert str(tmp_path) not in page.text
    assert sum(tag == "img" for tag, _ in page.tags) == 2


def test_source_picture_that_is_gone_is_told(tmp_path, view, result):
    _, page, _ = report(tmp_path, result, view, methods=[], image_path=tmp_path / "gone.png")
    assert "the picture cannot be read" in page.text


def test_figures_of_an_earlier_run_do_not_stay(tmp_path, view, result):
    methods = [dataclasses.replace(method, failure=None, histories=[]) for method in view.methods]
    report(tmp_path, result, view, methods=methods)
    assert (tmp_path / "figures" / "gravity-bracket.png").exists()
    own = tmp_path / "figures" / "my-own.png"
    own.write_bytes(b"mine")
    report(tmp_path, result, view, methods=methods[:1])
    names = {entry.name for entry in (tmp_path / "figures").iterdir()}
    assert "strength-bracket.png" in names
    assert not any(name.startswith("gravity") for name in names)
    assert own.read_bytes() == b"mine"


def test_no_room_keeps_the_old_report(tmp_path, view, result):
    (tmp_path / "report.html").write_text("old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    try:
        with pytest.raises(InputError, match="--out"):
            write_report(tmp_path / "report.html", result, dataclasses.replace(view, methods=[]))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert (tmp_path / "report.html").read_text() == "old"
    assert not [name for _, _, names in os.walk(tmp_path) for name in names if name.endswith(".part")]
