"""A changed project is taken over while everything else goes on.

New items appear, changed ones change, removed ones are unknown from then on; items, PLCs and links that did not
change keep their rows, values, memories and connections. Removals come before additions, so that a name can move.

Not here: reading and checking the file (``pcaccess.project.load``); a file with errors never gets here.
"""

from __future__ import annotations

from dataclasses import replace

from pcaccess.gateway.gateway import Gateway
from pcaccess.gateway.programs import Programs, load_programs
from pcaccess.gateway.station import Station
from pcaccess.project.diff import Changes, compare
from pcaccess.project.model import Item, Link, Plc, Project


def apply_project(gateway: Gateway, project: Project, programs: Programs | None = None) -> Changes:
    """Make ``gateway`` run ``project`` and say what was different; programs are read here unless given."""
    loaded = load_programs(project) if programs is None else programs
    programs_before = gateway.programs.by_station
    changed = [name for name, new in loaded.by_station.items() if programs_before.get(name, new) != new]
    done = replace(compare(gateway.project, project), programs=len(changed))
    old_links = {link.name: link for link in gateway.project.links}
    new_links = {link.name: link for link in project.links}
    gateway.project, gateway.programs = project, loaded
    kept = {name for name, link in old_links.items() if name in new_links and _same_connection(link, new_links[name])}
    for name in old_links.keys() - kept:
        gateway.remove_link(name)
    for name in kept:
        _remove_from_link(gateway, new_links[name])
    for name in kept:
        _add_to_link(gateway, new_links[name])
    for name, link in new_links.items():
        if name not in kept:
            gateway.add_link(link)
    gateway.set_groups()
    gateway.show()
    gateway.structure_changed()
    return done


def _same_connection(old: Link, new: Link) -> bool:
    """Everything of the link but its PLCs and where it stands in the file is as before."""
    return replace(old, plcs=new.plcs, description=new.description) == new


def _same_station(old: Plc, new: Plc) -> bool:
    """The PLC can keep its rows: it is reached in the same way, and has or lacks a CPU as before."""
    return (
        old.cpu,
        old.address,
        old.host,
        old.port,
        old.local_tsap,
        old.remote_tsap,
        old.unit,
        old.program is None,
    ) == (
        new.cpu,
        new.address,
        new.host,
        new.port,
        new.local_tsap,
        new.remote_tsap,
        new.unit,
        new.program is None,
    )


def _remove_from_link(gateway: Gateway, link: Link) -> None:
    plcs = {plc.item_id: plc for plc in link.plcs}
    for station in [s for s in gateway.stations.values() if s.plc.link == link.name]:
        plc = plcs.get(station.name)
        if plc is None or not _same_station(station.plc, plc):
            gateway.remove_station(station.name)
        else:
            _update_items(gateway, station, plc)


def _update_items(gateway: Gateway, station: Station, plc: Plc) -> None:
    """Remove what is gone or has another place or type; replace what only reads differently."""
    wanted = {item.item_id: item for item in plc.all_items()}
    dynamic = set(gateway.dynamic.rows_of(station))
    if station.plc.write_limits != plc.write_limits:
        gateway.dynamic.drop(dynamic)
        dynamic = set()
    gone = []
    for row, item in list(station.items()):
        if row in dynamic:
            continue
        new = wanted.get(item.item_id)
        if new is None or not _same_value(item, new):
            gone.append(row)
        else:
            gateway.replace_item(row, new)
    gateway.remove_items(gone)


def _same_value(old: Item, new: Item) -> bool:
    return (old.address, old.data_type, old.raw_type, old.length, old.scaling) == (
        new.address,
        new.data_type,
        new.raw_type,
        new.length,
        new.scaling,
    )


def _add_to_link(gateway: Gateway, link: Link) -> None:
    gateway.driver(link.name).configure(link.plcs)
    for plc in link.plcs:
        station = gateway.stations.get(plc.item_id)
        if station is None:
            gateway.add_station(link, plc)
            continue
        station.plc = plc
        present = {item.item_id for _, item in station.items()}
        new = [item for item in plc.all_items() if item.item_id not in present]
        gateway.add_items(station, new)
