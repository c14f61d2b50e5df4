"""`rover link bench` on the real firmware: nothing is lost or repeated, however bad the wire."""

from __future__ import annotations

import json
from typing import Any

import pytest

pytestmark = pytest.mark.rig("sitl")
BAD_BUS = ("--drop", 0.2, "--duplicate", 0.1, "--delay", 0.1, "--reorder", 0.1)


@pytest.fixture
def bench(rover):
    pytest.importorskip("rover_hil")

    def call(*options: object) -> dict:
        result = rover("link", "bench", "--rig", "sitl", "--json", *options)
        if result.code == 3:
            pytest.skip(f"the sitl rig does not start: {result.err}")
        assert result.code == 0, result.err
        figures: dict[str, Any] = json.loads(result.out)
        return figures

    return call


@pytest.mark.parametrize(("transport", "wire"), [("serial", ("--bit-error-rate", 1e-4)), ("can", BAD_BUS)])
def test_on_a_bad_wire_every_segment_is_executed_once(bench, transport, wire) -> None:
    told = bench("--transport", transport, "--seconds", 10, *wire)
    assert told["segments_sent"] > 400
    assert told["segments_executed"] == told["segments_sent"]
    assert (told["segments_lost"], told["segments_repeated"]) == (0, 0)
    assert told["transmissions"] > told["segments_sent"], "the wire was bad indeed"
    assert told["clock_error_us"]["median"] < 100.0


def test_on_a_good_wire_nothing_is_sent_twice_and_the_figures_are_the_codecs(bench) -> None:
    told = bench("--seconds", 3, "--jitter-ms", 0)
    assert told["transmissions"] == told["segments_sent"]
    assert 30.0 < told["bytes_per_segment"] < 31.0, "16 and 14 bytes, and now and then a start"
    assert told["clock_error_us"]["p99"] < 50.0
    round_trip = told["round_trip_ms"]
    assert 0.0 < round_trip["median"] <= round_trip["p99"] <= 4.0, "the rig hands bytes over once a millisecond"


def test_the_same_seed_gives_the_same_figures(bench) -> None:
    def told(seed: int) -> dict[str, Any]:
        figures: dict[str, Any] = bench("--seconds", 1, "--drop", 0.1, "--seed", seed)
        return figures

    assert told(4) == told(4)


def test_a_device_needs_a_port(rover) -> None:
    result = rover("link", "bench", "--rig", "device")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "--port" in result.err
