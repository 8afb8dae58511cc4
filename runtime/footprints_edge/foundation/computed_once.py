"""A property that is computed once for each object."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

__all__ = ["computed_once"]

if TYPE_CHECKING:
    from functools import cached_property as computed_once
else:

    class computed_once:  # noqa: N801 - a decorator
        """`functools.cached_property` as it is from Python 3.12 on: without a lock.

        Before, one lock served all objects: two threads with an object each waited for each other,
        for ever if they read two such properties in different order. Threads that read one of the
        same object at once compute it twice.
        """

        def __init__(self, compute: Callable[[Any], Any]) -> None:
            self._compute = compute
            self.__doc__ = compute.__doc__

        def __set_name__(self, owner: type, name: str) -> None:
            self._name = name

        def __get__(self, instance: object, owner: type | None = None) -> Any:  # noqa: ANN401
            if instance is None:
                return self
            values = vars(instance)
            if self._name not in values:
                values[self._name] = self._compute(instance)
            return values[self._name]
