#!/usr/bin/env python3
"""ros2_type_hash.py: prints the type hash (REP 2016, RIHS01) of the ROS 2 messages that the bridge publishes.

A ROS 2 node tells the hash of a type with its writers, and warns of a writer whose hash is another one. It is the SHA-256 of a
description of the type as JSON: its fields in their order, then all types that it refers to, by name."""
import hashlib
import json

# type_description_interfaces/msg/FieldType
INT32, UINT32, FLOAT64, BYTE, STRING, NESTED = 6, 7, 11, 16, 17, 1
UNBOUNDED_SEQUENCE = 144

# As the .msg files of ROS 2 have them: field, type, name of a nested type.
TYPES = {
    "builtin_interfaces/msg/Time": [("sec", INT32, ""), ("nanosec", UINT32, "")],
    "std_msgs/msg/Header": [("stamp", NESTED, "builtin_interfaces/msg/Time"), ("frame_id", STRING, "")],
    "sensor_msgs/msg/JointState": [
        ("header", NESTED, "std_msgs/msg/Header"),
        ("name", UNBOUNDED_SEQUENCE + STRING, ""),
        ("position", UNBOUNDED_SEQUENCE + FLOAT64, ""),
        ("velocity", UNBOUNDED_SEQUENCE + FLOAT64, ""),
        ("effort", UNBOUNDED_SEQUENCE + FLOAT64, ""),
    ],
    "diagnostic_msgs/msg/KeyValue": [("key", STRING, ""), ("value", STRING, "")],
    "diagnostic_msgs/msg/DiagnosticStatus": [
        ("level", BYTE, ""),
        ("name", STRING, ""),
        ("message", STRING, ""),
        ("hardware_id", STRING, ""),
        ("values", UNBOUNDED_SEQUENCE + NESTED, "diagnostic_msgs/msg/KeyValue"),
    ],
    "diagnostic_msgs/msg/DiagnosticArray": [
        ("header", NESTED, "std_msgs/msg/Header"),
        ("status", UNBOUNDED_SEQUENCE + NESTED, "diagnostic_msgs/msg/DiagnosticStatus"),
    ],
}


def description(name):
    fields = [{"name": field, "type": {"type_id": kind, "capacity": 0, "string_capacity": 0, "nested_type_name": nested}}
              for field, kind, nested in TYPES[name]]
    return {"type_name": name, "fields": fields}


def referenced(name):
    """Names of all types that this one refers to, directly or not."""
    found = set()
    for _, _, nested in TYPES[name]:
        if nested:
            found |= {nested} | referenced(nested)
    return found


def type_hash(name):
    whole = {"type_description": description(name),
             "referenced_type_descriptions": [description(other) for other in sorted(referenced(name))]}
    return "RIHS01_" + hashlib.sha256(json.dumps(whole, separators=(", ", ": ")).encode()).hexdigest()


if __name__ == "__main__":
    for each in TYPES:
        print(each, type_hash(each))
