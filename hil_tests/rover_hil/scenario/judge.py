"""Watches a run for what the scenario expects, forbids, and asks for at its end. Pure: moments in, verdicts out."""

from __future__ import annotations

from dataclasses import dataclass

from rover_hil.scenario.language import START, Check, Expectation, Scenario
from rover_hil.scenario.observation import Moment, Values

TIME_TOLERANCE_S = 1e-9


@dataclass(frozen=True)
class Verdict:
    """One thing that was asked for. `at`: seconds after its reference event, when it came true or was broken."""

    name: str
    asked: str
    passed: bool
    at: float | None
    detail: str


class Judge:
    """Takes events and moments in the order of time."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._events: dict[str, Moment] = {}
        self._verdicts: dict[str, Verdict] = {}
        self._pending = list(scenario.expectations)

    @property
    def decided(self) -> bool:
        """True when no expectation waits any more."""
        return not self._pending

    def event(self, name: str, moment: Moment) -> None:
        """Something has begun that others refer to."""
        self._events.setdefault(name, moment)

    def see(self, moment: Moment) -> list[str]:
        """Takes a moment; returns the names of the expectations that it has fulfilled."""
        for prohibition in self._scenario.prohibitions:
            since = self._events.get(prohibition.after)
            over = prohibition.until in self._events
            broken = since is not None and not over and prohibition.check.condition(moment.values)
            if broken and prohibition.name not in self._verdicts:
                assert since is not None
                at = moment.time - since.time
                text, detail = f"never: {prohibition.check.text}", f"it was after {at:.3f} s"
                self._verdicts[prohibition.name] = Verdict(prohibition.name, text, False, at, detail)
        fulfilled = []
        for expectation in list(self._pending):
            verdict = self._look(expectation, moment)
            if verdict is not None:
                self._pending.remove(expectation)
                self._verdicts[expectation.name] = verdict
                if verdict.passed:
                    self.event(expectation.name, moment)
                    fulfilled.append(expectation.name)
        return fulfilled

    def finish(self, moment: Moment, over: bool) -> list[Verdict]:
        """All verdicts, in the order of the file. `over`: the run came to its end in time."""
        for expectation in self._pending:
            never = "" if expectation.after in self._events else f" and {expectation.after} never came"
            missing = f"the run ended{never}"
            self._verdicts[expectation.name] = Verdict(expectation.name, _asked(expectation), False, None, missing)
        verdicts = [self._verdicts[expectation.name] for expectation in self._scenario.expectations]
        for prohibition in self._scenario.prohibitions:
            kept = Verdict(prohibition.name, f"never: {prohibition.check.text}", True, None, "")
            verdicts.append(self._verdicts.get(prohibition.name, kept))
        origin = self._events.get(START)
        for check in self._scenario.end:
            held = _holds(check, moment, origin)
            verdicts.append(Verdict("end", check.text, held, None, "" if held else _seen(check, moment.values)))
        if not over:
            text = f"over within {self._scenario.max_duration:g} s"
            detail = f"the drive or a fault still lasted at {moment.time:.2f} s"
            verdicts.append(Verdict("end", text, False, None, detail))
        return verdicts

    def _look(self, expectation: Expectation, moment: Moment) -> Verdict | None:
        since = self._events.get(expectation.after)
        if since is None:
            return None
        elapsed = moment.time - since.time
        if elapsed < expectation.begin - TIME_TOLERANCE_S:
            return None
        asked = _asked(expectation)
        failing = [check for check in expectation.checks if not _holds(check, moment, since)]
        if elapsed > expectation.within + TIME_TOLERANCE_S:
            detail = "; ".join(_seen(check, moment.values) for check in failing) or "it held too late"
            return Verdict(expectation.name, asked, False, None, f"not within {expectation.within:g} s: {detail}")
        if failing:
            return None
        if elapsed < expectation.not_before - TIME_TOLERANCE_S:
            return Verdict(expectation.name, asked, False, elapsed, f"too early, after {elapsed:.3f} s")
        return Verdict(expectation.name, asked, True, elapsed, "")


def _asked(expectation: Expectation) -> str:
    what = " and ".join(check.text for check in expectation.checks)
    start = max(expectation.not_before, expectation.begin)
    earliest = f"{start:g} to " if start else ""
    return f"{what}, {earliest}{expectation.within:g} s after {expectation.after}"


def _holds(check: Check, moment: Moment, since: Moment | None) -> bool:
    if check.moved_below is not None:
        before = float(since.values["travelled_m"]) if since is not None else 0.0
        return float(moment.values["travelled_m"]) - before < check.moved_below
    return check.condition(moment.values)


def _seen(check: Check, values: Values) -> str:
    names = [name for name in values if name in check.text.replace("stopped", "speed turn_rate").split()]
    shown = ", ".join(f"{name} is {_short(values[name])}" for name in names)
    if check.moved_below is not None:
        shown = f"travelled_m is {float(values['travelled_m']):.3f}"
    return f"{check.text} (but {shown})" if shown else check.text


def _short(value: float | str | bool) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
