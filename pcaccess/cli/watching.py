"""Items of a server as they change: the first Test Client.

A lost connection is not the end: the items go COMM_FAILURE with their last value and time, as with any PLC that is
gone, and come back when the server does.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Protocol

from asyncua.ua.attribute_ids import AttributeIds

from pcaccess.cli.failures import Failed
from pcaccess.cli.names import Found, Target, Unknown, content, expand, items_below, resolve
from pcaccess.cli.reading import is_write_only, needs_quality, read_qualities, shown
from pcaccess.cli.remote import Change, Lost, Remote, connect, status_name, status_text
from pcaccess.cli.samples import Shown
from pcaccess.clock import Clock
from pcaccess.items.quality import Quality

INTERVAL: Final = 0.1
"""Seconds between looks, when nobody says."""
RETRY: Final = 1.0
"""Seconds between attempts to reach a server that went away."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to watch and for how long."""

    names: Sequence[str] = ()
    """Items, branches, patterns; without any and without a group, all items."""
    group: str | None = None
    interval: float | None = None
    """Seconds; None takes the group's update rate."""
    count: int | None = None
    """End after so many changes."""
    duration: float | None = None
    """End after so many seconds."""


class View(Protocol):
    """Where the changes go."""

    def begin(self, items: Sequence[str], interval: float) -> None:
        """These items are watched now; called again when the server came back."""

    def show(self, samples: Sequence[Shown]) -> None: ...

    def remark(self, text: str) -> None:
        """Something about the connection; an empty text: it is well again."""

    def left_out(self, why: str, *, is_failure: bool) -> None:
        """An item that is not watched; no failure when nobody named it and it can only be written."""


async def watch(url: str, wanted: Wanted, view: View, clock: Clock, failures: list[str]) -> None:
    """Show changes until enough were seen. ``failures`` gets what cannot be watched, in words, once it is known."""
    await _Watcher(url, wanted, view, clock, failures).run()


@dataclass(slots=True)
class _Watcher:
    url: str
    wanted: Wanted
    view: View
    clock: Clock
    failures: list[str]
    _told: set[str] = field(default_factory=set)
    """Why items are left out: said once, however often the server comes back."""
    _last: dict[str, Shown] = field(default_factory=dict)
    _seen: int = 0
    _begun: bool = False

    async def run(self) -> None:
        try:
            async with asyncio.timeout(None) as limit:
                await self._keep_watching(limit)
        except TimeoutError:
            if not limit.expired():
                raise

    async def _keep_watching(self, limit: asyncio.Timeout) -> None:
        while True:
            try:
                async with connect(self.url) as remote:
                    await self._watch(remote, limit)
                    return
            except Failed as failed:
                if not self._begun:
                    raise
                if isinstance(failed, Lost):
                    self._lost(f"{failed}; trying again")
            if self._enough:
                return
            await self.clock.sleep(RETRY)

    async def _watch(self, remote: Remote, limit: asyncio.Timeout) -> None:
        targets, interval = await self._targets(remote)
        first, self._begun = not self._begun, True
        self.view.remark("")
        statuses = await remote.subscribe([target.node for target in targets], interval)
        good = [target.item_id for target, status in zip(targets, statuses, strict=True) if not status]
        self.view.begin(good, interval)
        if first and self.wanted.duration is not None:  # not before: thousands of items take their time
            limit.reschedule(asyncio.get_running_loop().time() + self.wanted.duration)
        for target, status in zip(targets, statuses, strict=True):
            if status:
                is_failure = target.is_named or not is_write_only(status)
                self._left_out(f"{target.item_id}: {status_text(status)}", is_failure=is_failure)
        if not good:
            return
        while not self._enough:
            self._show(await self._samples(remote, targets, await remote.changes()))

    @property
    def _left(self) -> int | None:
        return None if self.wanted.count is None else self.wanted.count - self._seen

    @property
    def _enough(self) -> bool:
        return self._left is not None and self._left <= 0

    async def _samples(self, remote: Remote, targets: Sequence[Target], changes: Sequence[Change]) -> list[Shown]:
        changed = [(targets[handle], value) for handle, value in changes]
        unclear = [target for target, value in changed if needs_quality(value)]
        codes = iter(await read_qualities(remote, unclear)) if unclear else iter(())
        return [shown(target, value, next(codes) if needs_quality(value) else None) for target, value in changed]

    def _show(self, samples: Sequence[Shown]) -> None:
        some = samples[: self._left]
        self._seen += len(some)
        self._last.update((sample.item_id, sample) for sample in some)
        self.view.show(some)

    def _lost(self, why: str) -> None:
        self.view.remark(why)
        quality, status = Quality.COMM_FAILURE.code, Quality.COMM_FAILURE.status()
        name = status_name(status)
        self._show([replace(s, quality=quality, status=status, status_name=name) for s in self._last.values()])

    # ------------------------------------------------------------------ what to watch

    async def _targets(self, remote: Remote) -> tuple[list[Target], float]:
        interval = self.wanted.interval
        found: list[Found] = []
        if self.wanted.group is not None:
            members, rate = await _group(remote, self.wanted.group)
            found += members
            interval = rate if interval is None else interval
        if self.wanted.names:
            found += await expand(remote, self.wanted.names)
        elif self.wanted.group is None:
            found += await items_below(remote, remote.roots())
        unknown = [one.message for one in found if isinstance(one, Unknown)]
        targets = list({one.node: one for one in found if isinstance(one, Target)}.values())
        if not targets:
            raise Failed("\n".join(unknown) or f"{remote.url} serves no items")
        for message in unknown:
            self._left_out(message)
        return targets, INTERVAL if interval is None else interval

    def _left_out(self, why: str, *, is_failure: bool = True) -> None:
        if why in self._told:
            return
        self._told.add(why)
        if is_failure:
            self.failures.append(why)
        self.view.left_out(why, is_failure=is_failure)


async def _group(remote: Remote, name: str) -> tuple[list[Found], float | None]:
    """Items of a group of the server and its update rate in seconds."""
    node = remote.group(name)
    if node is None:
        raise Failed(f"{remote.url} is not pcaccess and has no groups")
    kind, rate = await remote.read(
        [(node, AttributeIds.NodeClass), (remote.group(f"{name}/UpdateRate") or node, AttributeIds.Value)]
    )
    if content(kind) is None:
        raise Failed(f"there is no group {name}{await _other_groups(remote)}")
    (members,) = await remote.children([node])
    milliseconds = content(rate)
    found = await resolve(remote, [remote.name(member.NodeId) for member in members])
    return found, milliseconds / 1000 if milliseconds else None


async def _other_groups(remote: Remote) -> str:
    root = remote.groups()
    (groups,) = await remote.children([root], properties=True) if root is not None else ([],)
    names = [str(group.BrowseName.Name) for group in groups]
    return f"; there are {', '.join(names)}" if names else "; the project has none"
