"""Long work in steps: a generator yields the fraction that is done and returns its result.

A generator of `Parts` yields the fraction and a function to call, and receives what the function returned. Its parts
run in the calling thread (`at_once`) or in another one (`beside`).
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any, TypeVar

from .base import DimpleError

Parts = Generator[tuple[float, Callable[[], Any]], Any, Any]

_Result = TypeVar("_Result")


def as_share(
    steps: Generator[float, None, _Result], done: float, share: float
) -> Generator[float, None, _Result]:
    """Run one part of the work and yield the fraction of the whole.

    Args:
        done: fraction of the whole that was done before.
        share: fraction of the whole that this part makes up.
    """
    while True:
        try:
            part = next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found
        yield done + share * part


def at_once(parts: Parts) -> Any:
    """Call each part in turn and return the result."""

    def called(call: Callable[[], Any]) -> Generator[float, None, Any]:
        yield 0.0
        return call()

    steps = _driven(parts, called)
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


def beside(parts: Parts, look_s: float) -> Generator[float, None, Any]:
    """Call each part in a thread and yield the fraction that is done; after `close` the running part is abandoned.

    Args:
        look_s: time between two yields [s].

    Returns:
        the result.
    """
    pool = ThreadPoolExecutor(1)

    def waited(call: Callable[[], Any]) -> Generator[float, None, Any]:
        future = pool.submit(call)
        while not wait([future], look_s).done:
            yield 0.0
        return future.result()

    try:
        return (yield from _driven(parts, waited))
    finally:
        pool.shutdown(wait=False)


def _driven(
    parts: Parts, run: Callable[[Callable[[], Any]], Generator[float, None, Any]]
) -> Generator[float, None, Any]:
    """Run each part in steps; send its result or throw its error into the generator, and yield the fraction done."""
    send, value = parts.send, None
    try:
        while True:
            try:
                share, call = send(value)
            except StopIteration as end:
                return end.value
            try:
                send, value = parts.send, (yield from as_share(run(call), share, 0.0))
            except DimpleError as error:  # the generator may handle it
                send, value = parts.throw, error
    finally:
        parts.close()
