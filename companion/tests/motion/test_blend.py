"""Corners: rounded where there is room, turned on the spot where there is none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.motion.path import corner
from rover.motion.path.blend import blend_path as blended
from rover.motion.path.clearance import ClearanceMap
from rover.motion.path.limits import DrivingLimits
from rover.motion.path.piece import Piece
from rover.motion.path.rounding import BlendSettings
from rover.planning.fields import CircleField, GridField
from rover.vehicle import Vehicle

LIMITS = DrivingLimits.of(Vehicle())


def blend_path(*arguments, **settings):
    return blended(*arguments, **settings).stretches


RIGHT_ANGLE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]


def curves(stretches):
    return [piece for stretch in stretches for piece in stretch.pieces if piece.angle]


SHAPES = range(len(corner.LEVELS))


def sampled(piece, count):
    return piece.points(count)


def cut_of(piece):
    """Metres between the corner that a symmetric curve rounds and the curve."""
    points = piece.points(64)
    tangent = math.dist(points[0], points[-1]) / 2.0 / math.cos(piece.angle / 2.0)
    corner_ = points[0] + tangent * np.array([math.cos(piece.heading), math.sin(piece.heading)])
    return math.dist(points[32], corner_)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("degrees", [1, 20, 60, 90, 119])
def test_a_curve_leaves_one_leg_and_joins_the_other_with_the_cut_that_is_said(degrees, shape):
    form = np.array([shape])
    angle = np.array([math.radians(degrees)])
    tangent, cut = (each[0] for each in corner.tangent_and_cut(angle, form))
    zero, one = np.zeros(1), np.ones(1)
    points = corner.points(zero, zero, zero, angle, one, form, 64)[0]
    joined = tangent + tangent * np.array([math.cos(angle[0]), math.sin(angle[0])]) * [1, 1]
    assert points[-1] == pytest.approx([joined[0], tangent * math.sin(angle[0])], abs=1e-6)
    assert math.dist(points[32], (tangent, 0.0)) == pytest.approx(cut, abs=1e-6)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_shape_has_the_peaks_that_the_limits_are_computed_from(shape):
    u = np.linspace(0.0, 1.0, 2001)
    piece = Piece(0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, corner.parts(1.0, 1.0, shape))
    values = np.array([piece.turning(float(each)) for each in u])
    assert values[:, 1].max() == pytest.approx(corner.PEAK_CURVATURE[shape])
    assert np.abs(values[:, 2]).max() == pytest.approx(corner.PEAK_SLOPE[shape], rel=4e-3)
    assert values[:, 0] == pytest.approx(corner.turned(u, shape), abs=1e-12)
    assert np.gradient(values[:, 0], u)[1:-1] == pytest.approx(values[1:-1, 1], abs=1e-3)


@given(st.integers(0, 10_000), st.floats(0.005, 0.2))
@settings(max_examples=60, deadline=None)
def test_pieces_join_without_a_gap_or_a_kink_in_heading_or_curvature(seed, cut):
    rng = np.random.default_rng(seed)
    headings = np.cumsum(rng.normal(0.0, 1.0, 8))
    steps = rng.uniform(0.05, 1.0, 8)[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    path = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    stretches = blend_path(path, LIMITS, BlendSettings(max_cut=cut))
    for stretch in stretches:
        first = stretch.pieces[0]
        (x, y), heading, curvature, rate = (first.x, first.y), first.heading, 0.0, 0.0
        for piece in stretch.pieces:
            assert math.dist((piece.x, piece.y), (x, y)) < 5e-3  # nodes of bends; steering makes up for it
            assert math.remainder(piece.heading - heading, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
            assert piece.curvature == pytest.approx(curvature, abs=1e-6)
            assert piece.curvature_rate == pytest.approx(rate, abs=1e-3)
            assert piece.length > 0.0
            (x, y), heading = sampled(piece, 64)[-1], piece.heading + piece.angle
            _, curvature, rate = piece.turning(piece.length)
        assert curvature == pytest.approx(0.0, abs=1e-6)


def test_a_corner_without_room_is_turned_on_the_spot():
    assert curves(blend_path(RIGHT_ANGLE, LIMITS, BlendSettings(max_cut=0.05)))
    assert not curves(blend_path(RIGHT_ANGLE, LIMITS, BlendSettings(max_cut=0.001)))
    assert len(blend_path(RIGHT_ANGLE, LIMITS, BlendSettings(max_cut=0.0))) == 2


def test_a_sharp_corner_is_turned_on_the_spot_however_much_room_there_is():
    back = [(0.0, 0.0), (2.0, 0.0), (0.5, 0.3)]
    assert len(blend_path(back, LIMITS, BlendSettings(max_cut=0.5))) == 2


@pytest.mark.parametrize("exact", [True, False])
def test_a_curve_stays_where_the_map_is_free(exact):
    """A post on the inside of the corner: the nearer it stands the less is cut."""
    cuts = []
    for gap in (0.35, 0.2, 0.13, 0.104):
        inside = 0.15 + 0.1 + gap
        place = (1.5 - inside * math.sqrt(0.5), 1.0 + inside * math.sqrt(0.5))
        field = CircleField(3.0, 3.0, [(*place, 0.1)])
        clearance = ClearanceMap.of(field, 0.15)
        if not exact:
            clearance = ClearanceMap(clearance.margin)
        path = [(0.5, 1.0), (1.5, 1.0), (1.5, 2.0)]
        found = curves(blend_path(path, LIMITS, BlendSettings(max_cut=0.4), clearance))
        cuts.append(cut_of(found[0]) if found else 0.0)
        for piece in found:
            assert field.clearance(sampled(piece, 200)).min() >= 0.15
    assert cuts[0] >= cuts[1] >= cuts[2] >= cuts[3] > 0.0
    assert cuts[3] < 0.8 * cuts[0]


def test_a_corner_that_wraps_around_a_post_is_cut_by_the_room_there_is_and_no_more():
    post = (1.0, 1.0, 0.2)
    turn = math.radians(50.0)
    apex = 0.35 / math.cos(turn / 2) + 1e-6
    reach = apex * math.sin(turn / 2) + 0.8
    path = [
        (1.0 - reach * math.cos(turn / 2), 1.0 + apex - reach * math.sin(turn / 2)),
        (1.0, 1.0 + apex),
        (1.0 + reach * math.cos(turn / 2), 1.0 + apex - reach * math.sin(turn / 2)),
    ]
    stretches = blend_path(
        path, LIMITS, BlendSettings(max_cut=0.3), ClearanceMap.of(CircleField(3.0, 3.0, [post]), 0.15)
    )
    free = blend_path(path, LIMITS, BlendSettings(max_cut=0.3), ClearanceMap.of(CircleField(3.0, 3.0, []), 0.15))
    assert len(free) == 1
    room = apex - 0.35
    assert all(cut_of(piece) <= room for piece in curves(stretches))


def test_a_sweep_is_called_clear_only_where_it_is():
    """Against the planner's exact check, by the lower bound alone and with it; the map's cells are squares."""
    rng = np.random.default_rng(3)
    field = GridField(rng.random((60, 60)) < 0.02, 0.05)
    a, b = rng.uniform(0.2, 2.8, (400, 2)), rng.uniform(-0.2, 0.2, (400, 2))
    b += a
    exact = np.array([field.segment_clear(tuple(p), tuple(q), 0.151) for p, q in zip(a, b, strict=True)])
    clearance, slack = ClearanceMap.of(field, 0.15), np.full(400, 0.001)
    careful = ClearanceMap(clearance.margin).swept(a, b, slack)
    assert not (careful & ~exact).any()
    assert careful.sum() > 20
    assert (clearance.swept(a, b, slack) & ~exact).sum() == 0
    assert 0 < exact.sum() < 400


def test_small_corners_get_the_shape_of_least_jerk_and_large_ones_that_of_least_curvature():
    angles = np.radians([10.0, 40.0, 80.0, 119.0])
    chosen = LIMITS.corner_shape(angles)
    assert corner.LEVELS[chosen[0]] == 0.0
    assert corner.LEVELS[chosen[-1]] > 0.2
    assert (np.diff(chosen) >= 0).all()
    length = np.full(4, 0.1)
    best = LIMITS.corner_speed(angles, length, chosen)
    for shape in SHAPES:
        assert (LIMITS.corner_speed(angles, length, np.full(4, shape)) <= best * (1 + 1e-12)).all()


def test_speed_falls_with_curvature_clearance_and_sight():
    shape = LIMITS.corner_shape(np.full(2, math.pi / 2))
    slow, fast = (float(v) for v in LIMITS.corner_speed(np.full(2, math.pi / 2), np.array([0.2, 0.5]), shape))
    assert 0.0 < slow < fast < LIMITS.travel.speed
    assert slow**2 * corner.PEAK_CURVATURE[shape[0]] * (math.pi / 2) / 0.2 <= LIMITS.lateral
    field = CircleField(4.0, 2.0, [(2.0, 1.26, 0.1)])
    pieces = blend_path([(0.5, 1.0), (3.5, 1.0)], LIMITS, clearance=ClearanceMap.of(field, 0.15))[0].pieces
    speeds = {round(piece.speed, 3) for piece in pieces}
    assert min(speeds) < 0.22
    assert max(speeds) == LIMITS.travel.speed
    near = float(LIMITS.stopping_speed(np.array([0.05]))[0])
    a, j = LIMITS.travel.acceleration, LIMITS.travel.jerk
    assert near**2 / (2 * a) + near * (a / (2 * j) + LIMITS.latency) == pytest.approx(0.05)


@pytest.mark.parametrize("path", [[], [(0.0, 0.0)], [(1.0, 1.0), (1.0, 1.0)]])
def test_a_path_that_leads_nowhere_has_no_pieces(path):
    assert blend_path(path, LIMITS) == []


@pytest.mark.parametrize(
    "path", [[(0.0, 0.0), (math.nan, 1.0)], [(0.0, 0.0, 0.0)], [1.0, 2.0], "abc", [[1.0], [2.0, 3.0]]]
)
def test_what_is_no_path_is_bad_input_in_one_line(path):
    with pytest.raises(BadInput) as caught:
        blend_path(path, LIMITS)
    assert "\n" not in str(caught.value)
