"""Inside a room: its parts depend on one another in one direction.

A part of a room is a folder below include/driveline/<room> or src, or a file beside these folders; `master.hpp` and
the folder `master` are one part.
"""
from rooms import FOLDERS, INCLUDE, read_reasons, room_of, sources


def part_of(path):
    """Part of a path relative to include/driveline/<room> or src."""
    return path.parts[0].split(".")[0]


def bases(root, room):
    """Where headers and sources of a room lie."""
    folder = root / next(folder for folder, name in FOLDERS.items() if name == room)
    return [folder / "include" / "driveline" / room, folder / "src"]


def resolve(header, file, places, room):
    """The included file relative to the base it lies under, or None when it is none of this room."""
    own = f"driveline/{room}/"
    if header.startswith(own):
        return places[0].joinpath(header[len(own):]).relative_to(places[0])
    for folder in (file.parent, places[1]):
        target = folder / header
        for base in places:
            if target.is_file() and target.is_relative_to(base):
                return target.relative_to(base)
    return None


def edges(root, room):
    """{(part, part it includes): "file includes header" of the first such include}."""
    found = {}
    places = bases(root, room)
    for path in sources(root):
        file = root / path
        base = next((base for base in places if file.is_relative_to(base)), None)
        if base is None or room_of(path) != room:
            continue
        for match in INCLUDE.finditer(file.read_text(encoding="utf-8")):
            target = resolve(match.group(1), file, places, room)
            if target is None:
                continue
            edge = (part_of(file.relative_to(base)), part_of(target))
            if edge[0] != edge[1]:
                found.setdefault(edge, f"{path} includes {match.group(1)}")
    return found


def reachable(graph, start):
    seen, todo = set(), [start]
    while todo:
        for part in graph.get(todo.pop(), ()):
            if part not in seen:
                seen.add(part)
                todo.append(part)
    return seen


def cycles(found):
    """Sets of parts of which each depends on all others of its set."""
    graph = {}
    for user, used in found:
        graph.setdefault(user, set()).add(used)
    reach = {part: reachable(graph, part) for part in graph}
    groups = {frozenset(other for other in graph if other in reach[part] and part in reach[other])
              for part in graph if part in reach[part]}
    return sorted(groups, key=sorted)


def room_errors(root, room):
    """One error for each set of parts that depend on one another, with every edge between them."""
    found = edges(root, room)
    errors = []
    for group in cycles(found):
        lines = [f"  {user} -> {used}: {why}" for (user, used), why in sorted(found.items())
                 if user in group and used in group]
        errors.append("\n".join([f"room {room}: {', '.join(sorted(group))} depend on one another:", *lines]))
    return errors


def check(root, list_file):
    allowed = read_reasons(list_file)
    errors = [f"{list_file.name}: {room} is listed without a reason" for room, why in allowed.items() if len(why) < 10]
    for room in FOLDERS.values():
        found = room_errors(root, room)
        if room not in allowed:
            errors += found
        elif not found:
            errors.append(f"{list_file.name}: the parts of {room} depend on one another in one direction; take it off")
    return errors + [f"{list_file.name}: there is no room {room}" for room in allowed if room not in FOLDERS.values()]
