"""Our frozen dataclasses against those of the standard library."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from typing import Any

import pytest

from thermoroll_cli.frozen import frozen


class _Fields:
    """The fields of both classes below."""

    name: str
    size: float = 2.0
    names: list[str] = dataclasses.field(default_factory=list)
    made: float = dataclasses.field(init=False, default=0.0)

    @property
    def double(self) -> float:
        return 2.0 * self.size


def _both() -> list[Any]:
    def fresh() -> Any:
        body = {key: value for key, value in vars(_Fields).items() if key not in ("__dict__", "__weakref__")}
        return type("Sample", (), body)

    return [frozen(fresh()), dataclasses.dataclass(frozen=True)(fresh())]


@frozen
class Point:
    """A place, in m."""

    x: float
    y: float = 0.0


@frozen
class HighPoint(Point):
    """A place with a height."""

    z: float = 1.0


def test_they_are_made_shown_and_changed_alike() -> None:
    told = []
    for sample in _both():
        item = sample("a", names=["b"])
        told.append((repr(item), dataclasses.asdict(dataclasses.replace(item, size=3.0)), item.double, item == sample("a"),
                     item == sample("a", names=["b"]), item == ("a",), sample.__match_args__,
                     [field.name for field in dataclasses.fields(item)]))
        with pytest.raises(TypeError, match="name"):
            sample()
        with pytest.raises(TypeError, match="unhashable"):
            hash(item)
    assert told[0] == told[1]
    assert told[0][3:6] == (False, True, False)


@pytest.mark.parametrize("change", [
    lambda item: setattr(item, "x", 2.0), lambda item: setattr(item, "z", 2.0), lambda item: delattr(item, "x"),
])
def test_nothing_of_them_can_be_changed(change: Any) -> None:
    point = Point(1.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        change(point)
    assert vars(point) == {"x": 1.0, "y": 0.0}


def test_they_are_keys_and_can_be_copied_and_sent() -> None:
    assert {Point(1.0): "there"}[Point(1.0, 0.0)] == "there"
    assert len({Point(1.0), Point(1.0, 0.0), Point(2.0)}) == 2
    for twin in (copy.copy(Point(1.0)), copy.deepcopy(Point(1.0)), pickle.loads(pickle.dumps(Point(1.0)))):
        assert twin == Point(1.0)


def test_what_inherits_is_another_class() -> None:
    assert HighPoint(1.0) != Point(1.0)
    assert repr(HighPoint(1.0)) == "HighPoint(x=1.0, y=0.0, z=1.0)"
    with pytest.raises(dataclasses.FrozenInstanceError):
        HighPoint(1.0).z = 2.0  # type: ignore[misc]
