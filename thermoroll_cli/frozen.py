"""Frozen dataclasses that are quickly made.

`dataclasses` writes every method of every class as source text and compiles it, at each start of the program anew: for the
hundred classes of this program that takes longer than many a solve. Here it writes `__init__` alone; the methods that are alike
for all classes are written once, below.
"""

from __future__ import annotations

from dataclasses import FrozenInstanceError, dataclass, fields
from typing import Any, TypeVar, dataclass_transform

Made = TypeVar("Made")


@dataclass_transform(frozen_default=True)
def frozen(cls: type[Made]) -> type[Made]:
    """As `dataclasses.dataclass(frozen=True)`: equal, and of the same hash, are instances of one class with equal fields."""
    for name, method in _SHARED.items():
        if name not in vars(cls):
            setattr(cls, name, method)
    return dataclass(eq=False, repr=False)(cls)


def _set_once(self: Any, name: str, value: Any) -> None:
    # By __init__; whatever comes later finds the field there.
    if name in self.__dict__ or name not in self.__dataclass_fields__:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")
    self.__dict__[name] = value


def _keep(self: Any, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _values(self: Any) -> tuple[Any, ...]:
    return tuple(getattr(self, name) for name in self.__dataclass_fields__)


def _equal(self: Any, other: object) -> Any:
    return _values(self) == _values(other) if other.__class__ is self.__class__ else NotImplemented


def _hash(self: Any) -> int:
    return hash(_values(self))


def _text(self: Any) -> str:
    shown = ", ".join(f"{field.name}={getattr(self, field.name)!r}" for field in fields(self))
    return f"{self.__class__.__qualname__}({shown})"


_SHARED = {"__setattr__": _set_once, "__delattr__": _keep, "__eq__": _equal, "__hash__": _hash, "__repr__": _text}
