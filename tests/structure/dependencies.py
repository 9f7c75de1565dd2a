"""Doors between the rooms: what CMake links and what the sources include, against allowed_doors.txt."""
import re

from rooms import FOLDERS, INCLUDE, room_of, sources


def read_doors(file):
    """{room: set of rooms it may use}; every room of the house must have its line."""
    doors = {}
    for line in file.read_text(encoding="utf-8").splitlines():
        line = line.split("#")[0].strip()
        if line:
            room, _, targets = line.partition("->")
            doors[room.strip()] = set(targets.split())
    if set(doors) != set(FOLDERS.values()):
        raise SystemExit(f"{file}: the rooms listed are not the rooms of the house: "
                         f"{sorted(set(doors) ^ set(FOLDERS.values()))}")
    return doors


def allowed(doors, room, used):
    return used == room or used in doors[room] or "*" in doors[room]


def read_graph(file, root):
    """Link graph written by LinkGraph.cmake: {target: (room or None, names of its link items)}."""
    graph = {}
    for line in file.read_text(encoding="utf-8").splitlines():
        target, folder, items = line.split("\t")
        inside = folder.startswith(str(root))
        room = room_of(folder[len(str(root)) + 1:]) if inside else None
        # Link items may be wrapped in generator expressions, e.g. $<LINK_ONLY:driveline::wire>.
        graph[target] = (room, re.findall(r"[\w.+-]+(?:::[\w.+-]+)*", items))
    return graph


def link_errors(graph, doors):
    errors = []
    for target, (room, items) in sorted(graph.items()):
        if room is None:
            continue
        for item in items:
            used, _ = graph.get(item.replace("::", "_"), (None, None))
            if used and not allowed(doors, room, used):
                errors.append(f"target {target} of room {room} links {item}, but {room} may not use {used}")
    return errors


def graph_errors(graph):
    """The graph itself must be whole, or the check above would pass for lack of edges."""
    libraries = {room for target, (room, _) in graph.items() if target == f"driveline_{room}"}
    missing = {"rt", "bytes", "sdo", "wire", "canopen_wire", "port", "snapshot", "trajectory", "esi", "motion", "ecat_master", "slaves"} - libraries
    return [f"the link graph has no target driveline_{room}" for room in sorted(missing)]


def header_rooms(root):
    """Room by the name behind `driveline/` in an include. Tests may have such folders for what they share."""
    found = {room: room for room in FOLDERS.values()}
    for folder in (root / "tests").rglob("include/driveline/*"):
        found.setdefault(folder.name, "tests")
    return found


def include_errors(root, doors):
    errors = []
    rooms = header_rooms(root)
    for path in sources(root):
        text = (root / path).read_text(encoding="utf-8")
        room = room_of(path)
        for match in INCLUDE.finditer(text):
            included = match.group(1)
            where = f"{path}:{text.count(chr(10), 0, match.start()) + 1}"
            if ".." in included.split("/"):
                errors.append(f"{where} includes {included}: no way around the doors; use driveline/<room>/...")
            if not included.startswith("driveline/"):
                continue
            used = rooms.get(included.split("/")[1])
            if used is None:
                errors.append(f"{where} includes {included}, but there is no such room")
            elif not allowed(doors, room, used):
                errors.append(f"{where} includes {included}, but {room} may not use {used}")
    return errors


def check(root, doors_file, graph_file):
    doors = read_doors(doors_file)
    graph = read_graph(graph_file, root)
    return graph_errors(graph) + link_errors(graph, doors) + include_errors(root, doors)
