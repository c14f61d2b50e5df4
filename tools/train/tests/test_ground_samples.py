"""What a network for ground is learned from and tested on: hours apart, truth of a look, turning, counting."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES
from rover.detection.ground.image import GroundRectifier
from rover.detection.ground.patch import LENGTH, SIDE
from rover.geometry import Pose2
from rover.vision.camera.file import load_camera

from tools.train.ground.fields import HELD_OUT_HOURS, Field, draw_hour, expose, is_held_out, make_field
from tools.train.ground.look import in_view, truth_of
from tools.train.ground.samples import BACKGROUND, OBSTACLE, UNSURE, WAYS, Looks, look_at_fields, turned
from tools.train.measure import confusion_by_look, f1_scores
from tools.train.store import digest

CAMERA = load_camera("lepton-160")
SURFACE, BURIED = CLASSES.index("surface"), CLASSES.index("buried")


def looks(rows: Sequence[tuple[float, ...]], seen: Sequence[tuple[float, ...]], fields: list[int]) -> Looks:
    """Rows: look, mine, kind, contrast, to_mine, to_obstacle of candidates; seen: look, mine, kind, contrast."""
    look, mine, kind, contrast, to_mine, to_obstacle = np.array(rows, float).reshape(-1, 6).T
    return Looks(
        np.zeros((len(rows), LENGTH), np.float32),
        look.astype(int),
        mine.astype(int),
        kind.astype(int),
        contrast,
        np.full(len(rows), 0.055),
        to_mine,
        to_obstacle,
        np.array(seen, np.float32).reshape(-1, 4),
        np.array(fields),
    )


def answers(*names: str) -> NDArray[np.float64]:
    return np.array([[0.97 if name == other else 0.01 for other in CLASSES] for name in names])


# -- hours ---------------------------------------------------------------------------------------------------------


def test_hours_that_are_tested_are_never_learned_from() -> None:
    rng = np.random.default_rng(0)
    assert not any(is_held_out(draw_hour(rng, False)) for _ in range(500))
    tested = [draw_hour(rng, True) for _ in range(500)]
    assert all(is_held_out(hour) for hour in tested)
    assert all(any(begin <= hour < end for hour in tested) for begin, end in HELD_OUT_HOURS)


# -- truth of a look -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def field() -> Field:
    made = make_field(CAMERA, ("loam",), 3)
    assert made is not None
    return made


def test_a_mine_before_the_camera_is_in_view_and_the_spot_on_it_is_its(field: Field) -> None:
    mine = field.ground.mines[-1]
    pose = Pose2(mine.x - 0.6, mine.y, 0.0)
    rng = np.random.default_rng(0)
    image = GroundRectifier(CAMERA).rectify(expose(field, CAMERA, pose, np.zeros((120, 160), np.float32), rng))
    assert len(field.ground.mines) - 1 in in_view(image, pose, field.ground, CAMERA)
    behind = Pose2(mine.x + 0.6, mine.y, 0.0)
    assert len(field.ground.mines) - 1 not in in_view(image, behind, field.ground, CAMERA)


def test_a_casing_is_looked_for_where_it_appears_and_not_where_it_stands(field: Field) -> None:
    number, mine = next((i, m) for i, m in enumerate(field.ground.mines) if m.kind == "surface")
    pose = Pose2(mine.x - 0.75, mine.y, 0.0)
    truth = truth_of(np.array([[0.75, 0.0], [0.78, 0.0]]), pose, field.ground, CAMERA)
    assert truth.mine.tolist() == [number, number]
    assert truth.to_mine[1] < 0.005 < 0.02 < truth.to_mine[0]


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes() -> None:
    first, again = (look_at_fields(CAMERA, ("clay",), [8], 2, True) for _ in range(2))
    assert first.vectors.tobytes() == again.vectors.tobytes()
    assert first.seen.tobytes() == again.seen.tobytes()


# -- labels --------------------------------------------------------------------------------------------------------


def test_what_lies_between_two_classes_is_not_learned() -> None:
    rows = [
        (0, 0, BURIED, 1.0, 0.05, 9.0),
        (0, 0, BURIED, 1.0, 0.08, 9.0),
        (0, 0, BURIED, 1.0, 0.30, 9.0),
        (0, 0, BURIED, 0.1, 0.05, 9.0),
        (0, 0, BURIED, 1.0, 0.30, -0.02),
        (0, 0, BURIED, 1.0, 0.30, 0.03),
    ]
    wanted = [BURIED, UNSURE, BACKGROUND, UNSURE, OBSTACLE, UNSURE]
    assert looks(rows, [], [1]).labels().tolist() == wanted


def test_vectors_of_another_precision_are_refused() -> None:
    one = looks([(0, 0, BURIED, 1.0, 0.05, 9.0)], [], [1])
    with pytest.raises(ValueError, match="float32 is expected"):
        Looks(**{**vars(one), "vectors": one.vectors.astype(np.float16)})


def test_joined_looks_keep_their_mines() -> None:
    one = looks([(0, 0, BURIED, 1.0, 0.05, 9.0)], [(0, 0, BURIED, 1.0)], [1])
    both = Looks.join([one, one])
    assert both.look.tolist() == [0, 1]
    assert both.seen[:, 0].tolist() == [0, 1]


# -- turning -------------------------------------------------------------------------------------------------------


def test_pictures_are_turned_alike_and_numbers_stay() -> None:
    vector = np.arange(LENGTH, dtype=np.float32)[None]
    area = SIDE * SIDE
    for way in WAYS:
        moved = vector[:, way][0]
        assert moved[3 * area :].tolist() == vector[0, 3 * area :].tolist()
        assert (moved[area : 2 * area] - moved[:area] == area).all()
    assert len({tuple(way.tolist()) for way in WAYS}) == 8
    assert WAYS[0].tolist() == list(range(LENGTH))


def test_what_stands_out_of_the_ground_is_only_mirrored() -> None:
    vectors = np.tile(np.arange(LENGTH, dtype=np.float32), (400, 1))
    after = turned(vectors.copy(), np.full(400, OBSTACLE), np.random.default_rng(0))
    assert {tuple(row) for row in after.tolist()} == {tuple(vectors[0, WAYS[n]].tolist()) for n in (0, 4)}
    free = turned(vectors.copy(), np.full(400, BURIED), np.random.default_rng(0))
    assert len({tuple(row) for row in free.tolist()}) == 8


# -- counting ------------------------------------------------------------------------------------------------------


def test_a_mine_counts_once_a_look_and_also_where_no_candidate_lies_on_it() -> None:
    rows = [(0, 0, BURIED, 1.0, 0.02, 9.0), (0, 0, BURIED, 1.0, 0.12, 9.0), (0, 0, BURIED, 1.0, 0.4, 9.0)]
    seen = [(0, 0, BURIED, 1.0), (0, 1, SURFACE, 3.0), (0, 2, BURIED, 0.3)]
    table = confusion_by_look(looks(rows, seen, [1]), answers("background", "buried", "buried"), 0.5).sum(axis=0)
    assert table[BURIED].tolist() == [0, 0, 1, 0]
    assert table[SURFACE].tolist() == [0, 0, 0, 1]
    assert table[BACKGROUND].tolist() == [0, 0, 1, 0]


def test_f1_is_the_harmonic_mean_of_precision_and_recall() -> None:
    table = np.zeros((4, 4), int)
    table[2, 2], table[2, 3], table[3, 2] = 8, 2, 4
    precision, recall = 8 / 12, 8 / 10
    assert f1_scores(table)[2] == pytest.approx(2 * precision * recall / (precision + recall))


def test_a_store_of_other_code_has_another_name(tmp_path: Path) -> None:
    file = tmp_path / "code.py"
    file.write_text("a = 1\n")
    before = digest([file])
    file.write_text("a = 2\n")
    assert digest([file]) != before
