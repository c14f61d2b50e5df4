"""`rover trajectory`: figures of a path, and one line for what is no path."""

from __future__ import annotations

import json
import math
from xml.etree import ElementTree

import cv2
import pytest
from rover.cli.main import invoke

PATH = [[0.0, 0.0], [1.0, 0.0], [1.5, 0.6], [2.5, 0.6]]


def run(tmp_path, capsys, content, *options):
    file = tmp_path / "path.json"
    file.write_text(content if isinstance(content, str) else json.dumps(content))
    code = invoke(["trajectory", str(file), *options])
    return code, capsys.readouterr()


def test_the_figures_are_those_of_the_contract(tmp_path, capsys):
    code, output = run(tmp_path, capsys, {"status": "ok", "path": PATH}, "--json")
    result = json.loads(output.out)
    assert code == 0
    assert result["duration_s"] > 10.0
    assert result["bytes"] > 20 * result["segments"] > 0
    assert 0.01 < result["max_deviation_m"] <= 0.05
    assert result["max_speed"] <= 0.25
    assert result["max_acceleration"] <= 0.5
    assert result["max_jerk"] <= 3.0


def test_segments_are_written_as_the_integers_of_the_wire(tmp_path, capsys):
    file = tmp_path / "segments.csv"
    _, output = run(tmp_path, capsys, PATH, "--json", "--segments", str(file))
    rows = [[int(value) for value in line.split(",")] for line in file.read_text().splitlines()[1:]]
    assert len(rows) == json.loads(output.out)["segments"]
    assert rows[0][3] & 1
    assert rows[-1][3] & 2


def test_slower_gentler_and_nearer_to_the_path_when_asked(tmp_path, capsys):
    options = ("--cruise", "0.15", "--lateral", "0.05", "--tolerance", "0.01", "--json")
    result = json.loads(run(tmp_path, capsys, PATH, *options)[1].out)
    assert result["max_speed"] <= 0.15
    assert result["max_lateral_acceleration"] <= 0.05
    assert result["max_deviation_m"] <= 0.01


def test_a_map_bounds_the_cut_and_refuses_a_path_that_touches(tmp_path, capsys):
    field = tmp_path / "field.toml"
    field.write_text("width = 4.0\nheight = 4.0\nobstacles = [[2.0, 2.0, 0.3]]\n")
    clear = [[0.5, 0.5], [3.2, 0.5], [3.5, 3.0]]
    code, output = run(tmp_path, capsys, clear, "--map", str(field), "--json")
    assert code == 0
    assert json.loads(output.out)["curves"] == 1
    code, output = run(tmp_path, capsys, [[0.5, 2.0], [3.5, 2.0]], "--map", str(field))
    assert code == 2
    assert output.err.count("\n") == 1
    assert "not free near" in output.err


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[]",
        "[[0, 0]]",
        "[[0, 0], [1]]",
        "[[0, 0], [1, NaN]]",
        "[[0, 0], [1, 1e300]]",
        '{"way": []}',
        "[[0,0],[true,1]]",
    ],
)
def test_what_is_no_path_is_one_line_and_code_two(tmp_path, capsys, content):
    code, output = run(tmp_path, capsys, content)
    assert code == 2
    assert output.out == ""
    assert output.err.count("\n") == 1


@pytest.mark.parametrize("options", [("--cruise", "nan"), ("--cruise", "9"), ("--lateral", "0"), ("--tolerance", "-1")])
def test_options_out_of_range_are_one_line(tmp_path, capsys, options):
    code, output = run(tmp_path, capsys, PATH, *options)
    assert code == 2
    assert output.err.count("\n") == 1


def test_a_file_that_is_not_there_is_one_line(tmp_path, capsys):
    assert invoke(["trajectory", str(tmp_path / "none.json")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_path_to_where_the_rover_stands_is_no_motion(tmp_path, capsys):
    _, output = run(tmp_path, capsys, [[1, 1], [1, 1]], "--json")
    result = json.loads(output.out)
    assert result["segments"] == result["bytes"] == 0
    assert math.isclose(result["max_deviation_m"], 0.0)


def test_the_svg_plot_has_a_title_a_legend_axes_with_units_and_the_curves(tmp_path, capsys):
    file = tmp_path / "trajectory.svg"
    code, _ = run(tmp_path, capsys, PATH, "--plot", str(file))
    assert code == 0
    drawn = ElementTree.parse(file).getroot()
    texts = {each.text for each in drawn.iter() if each.tag.endswith("text")}
    assert {"Trajectory", "x, m", "y, m", "time, s", "speed, m/s", "acceleration, m/s²", "turn rate, rad/s"} <= texts
    assert {"path asked for", "driven", "at rest"} <= texts
    lines = [each.attrib for each in drawn.iter() if each.tag.endswith("polyline")]
    assert sum(each["points"].count(",") > 40 for each in lines) == 4  # the driven path and three profiles
    assert any(each["points"].count(",") == len(PATH) and "stroke-dasharray" in each for each in lines)


def test_the_ending_chooses_the_format_of_the_plot(tmp_path, capsys):
    file = tmp_path / "trajectory.png"
    assert run(tmp_path, capsys, PATH, "--plot", str(file))[0] == 0
    image = cv2.imread(str(file))
    assert image.shape[1] > 1000
    assert (image < 128).any(axis=2).mean() > 0.002
    code, output = run(tmp_path, capsys, PATH, "--plot", str(tmp_path / "trajectory.pdf"))
    assert code == 2
    assert "must end in .svg or .png" in output.err
