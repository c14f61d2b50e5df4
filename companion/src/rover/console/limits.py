"""How often somebody may ask: a bucket of tokens for each, and no more buckets than fit."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

MAX_BUCKETS = 1000


@dataclass
class Bucket:
    """tokens: requests that are still allowed. at: when that was so, seconds."""

    tokens: float
    at: float


class Limit:
    """So many requests a second, and so many at once, for each name; who has been silent longest is forgotten."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate = rate
        self._burst = burst
        self._buckets: OrderedDict[str, Bucket] = OrderedDict()

    def allows(self, name: str, now: float) -> bool:
        """Takes a token; False when there is none. `now`: seconds, monotonic."""
        bucket = self._buckets.pop(name, None) or Bucket(self._burst, now)
        self._buckets[name] = bucket
        if len(self._buckets) > MAX_BUCKETS:
            self._buckets.popitem(last=False)
        bucket.tokens = min(self._burst, bucket.tokens + (now - bucket.at) * self._rate)
        bucket.at = now
        if bucket.tokens < 1.0:
            return False
        bucket.tokens -= 1.0
        return True
