"""How far a run is, for whoever watches it."""

from dataclasses import dataclass
from time import monotonic


@dataclass(frozen=True)
class Progress:
    """After a step.

    Attributes:
        step: steps taken.
        steps: steps of the whole run; None where it has minutes instead.
        loss: of this step.
        pictures_per_s: over the last steps, data and all included.
        seconds_left: until the end, at this speed.
    """

    step: int
    steps: int | None
    loss: float
    pictures_per_s: float
    seconds_left: float

    def __str__(self) -> str:
        """One line."""
        of = "" if self.steps is None else f" of {self.steps}"
        minutes, seconds = divmod(round(self.seconds_left), 60)
        return (
            f"step {self.step}{of}, loss {self.loss:.3f}, {self.pictures_per_s:.1f} pictures/s, "
            f"{minutes // 60}:{minutes % 60:02}:{seconds:02} left"
        )


class Stopwatch:
    """Time spent on a run, that before an interruption included, and its recent speed."""

    def __init__(self, spent_s: float = 0.0) -> None:
        """Starts it.

        Args:
            spent_s: seconds that count already.
        """
        self._begin = monotonic() - spent_s
        self._last = monotonic()
        self._step_s: float | None = None

    @property
    def spent_s(self) -> float:
        """Seconds so far."""
        return monotonic() - self._begin

    def step_s(self) -> float:
        """Seconds a step, averaged over about the last twenty; call it once a step."""
        now = monotonic()
        took, self._last = now - self._last, now
        self._step_s = took if self._step_s is None else self._step_s + (took - self._step_s) / 20
        return self._step_s

    def skip(self) -> None:
        """What was done since the last step counts as time, but not as part of a step."""
        self._last = monotonic()
