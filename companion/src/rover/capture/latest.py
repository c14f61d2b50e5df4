"""A thread that reads a source so that nobody waits for a camera: the latest frames are kept, older ones counted."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable
from types import TracebackType

from rover.capture.frame import Frame

# Seconds that `close` waits for the thread; a driver that hangs in a read does not hold up the mission's end.
CLOSE_TIMEOUT = 2.0


class LatestFrames:
    """Reads `source` in a thread and keeps the latest `depth` frames; use it as a context manager.

    dropped: frames that nobody took in time. finished: the source has ended, and all it gave was taken.
    """

    def __init__(self, source: Iterable[Frame], depth: int = 2) -> None:
        self._waiting: deque[Frame] = deque()
        self._depth = depth
        self._lock = threading.Lock()
        self._stopping = threading.Event()
        self._error: BaseException | None = None
        self._ended = False
        self.dropped = 0
        self._thread = threading.Thread(target=self._read, args=(source,), name="capture", daemon=True)
        self._thread.start()

    def take(self) -> list[Frame]:
        """Every frame kept, oldest first; never waits. Raises what ended the source, once its frames are taken."""
        with self._lock:
            frames, self._waiting = list(self._waiting), deque()
            error = None if frames else self._error
        if error is not None:
            raise error
        return frames

    @property
    def finished(self) -> bool:
        """Whether nothing more will come."""
        with self._lock:
            return self._ended and not self._waiting

    def close(self) -> None:
        """Ends the thread after the frame that it reads; may be called twice."""
        self._stopping.set()
        self._thread.join(CLOSE_TIMEOUT)

    def __enter__(self) -> LatestFrames:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _read(self, source: Iterable[Frame]) -> None:
        try:
            for frame in source:
                with self._lock:
                    self._waiting.append(frame)
                    while len(self._waiting) > self._depth:
                        self._waiting.popleft()
                        self.dropped += 1
                if self._stopping.is_set():
                    break
        except BaseException as error:  # handed to whoever takes the next frame
            self._error = error
        finally:
            with self._lock:
                self._ended = True
