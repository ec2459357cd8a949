"""Mutations of a file's bytes that know what the bytes are: tables, trees, cells, headers."""

from __future__ import annotations

import copy
import json
import random
import re
import struct
import tomllib
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Callable
from io import BytesIO
from typing import Any

from fuzzing import odd

Mutation = Callable[[bytes, random.Random], bytes]

WORD = re.compile(r"[-+]?\d[\w.+-]*|[A-Za-z_][\w./{}:-]*")


def bytes_of(content: bytes, rng: random.Random) -> bytes:
    """Flips, cuts, doubled and lost pieces, large numbers."""
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 8, 40))):
        at = rng.randrange(len(data) + 1)
        kind, size = rng.randrange(8), rng.choice((1, 2, 4, 8, 64))
        if kind == 0:
            del data[at:]
        elif kind == 1:
            del data[at : at + size]
        elif kind == 2:
            data[at:at] = data[at : at + size] * rng.randrange(1, 4)
        elif kind == 3:
            data[at : at + size] = rng.randbytes(size)
        elif kind == 4:
            data[at : at + 4] = struct.pack(
                rng.choice("<>") + "I", rng.choice((0, 2**31, 2**32 - 1))
            )
        elif kind == 5:
            data[at : at + 8] = struct.pack("<d", rng.choice((1e308, float("nan"), -1.0)))
        elif data and at < len(data):
            data[at] ^= 1 << rng.randrange(8)
    return bytes(data)


def text_of(content: bytes, rng: random.Random) -> bytes:
    """Words and numbers replaced, lines moved, other encodings."""
    text = content.decode("utf-8", "replace")
    if not rng.randrange(12):
        form = rng.choice(("utf-16", "utf-32", "utf-8-sig", "latin-1", "cp037"))
        return text.encode(form, "replace")
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        words = list(WORD.finditer(text))
        lines = text.splitlines(keepends=True)
        if rng.randrange(3) and words:
            word = rng.choice(words)
            new = str(odd.value(rng)) if rng.randrange(3) else rng.choice(words)[0]
            text = text[: word.start()] + new + text[word.end() :]
        elif lines:
            at = rng.randrange(len(lines))
            lines[at:at] = [rng.choice(lines)] * rng.randrange(2)
            if rng.randrange(2):
                del lines[rng.randrange(len(lines))]
            text = "".join(lines)
    return text.encode("utf-8", "surrogatepass")


def tree_of(document: Any, rng: random.Random) -> Any:
    """A copy in which entries are lost, doubled, swapped, of other types, or odd."""
    document = copy.deepcopy(document)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        places = list(_places(document))
        if not places:
            return odd.value(rng)
        inside, key = rng.choice(places)
        kind = rng.randrange(7)
        if kind == 0:
            del inside[key]
        elif kind == 1 and isinstance(inside, dict):
            inside[rng.choice(odd.TEXTS)] = inside[key]
        elif kind == 1:
            inside.insert(key, copy.deepcopy(inside[key]))
        elif kind == 2:
            other, at = rng.choice(places)
            inside[key] = copy.deepcopy(other[at]) if at in _keys(other) else odd.value(rng)
        elif kind == 3 and isinstance(inside[key], int | float):
            inside[key] = rng.choice(odd.NUMBERS)
        elif kind == 4 and isinstance(inside[key], list):
            inside[key] = inside[key][: rng.randrange(len(inside[key]) + 1)]
        elif kind == 5 and isinstance(inside[key], str):
            inside[key] = rng.choice(odd.TEXTS)
        else:
            inside[key] = odd.value(rng)
    return document


def _keys(inside: Any) -> Any:
    return inside.keys() if isinstance(inside, dict) else range(len(inside))


def _places(document: Any) -> Any:
    """(container, key) of every entry; of long lists a few, so that keys count as much."""
    waiting = [document]
    while waiting:
        inside = waiting.pop()
        keys = list(_keys(inside)) if isinstance(inside, dict | list) else []
        if isinstance(inside, list) and len(keys) > 6:
            keys = [*keys[:3], *keys[-3:]]
        for key in keys:
            yield inside, key
            waiting.append(inside[key])


def json_of(content: bytes, rng: random.Random) -> bytes:
    """A table of JSON, or its text."""
    if not rng.randrange(6):
        return text_of(content, rng)
    if not rng.randrange(40):
        return b"[" * 100_000
    return json.dumps(tree_of(json.loads(content), rng)).encode()


def toml_of(content: bytes, rng: random.Random) -> bytes:
    """A table of TOML, or its text."""
    if not rng.randrange(4):
        return text_of(content, rng)
    if not rng.randrange(40):
        return b"a = " + b"[" * 20_000
    table = tree_of(tomllib.loads(content.decode()), rng)
    return _toml(table).encode("utf-8", "surrogatepass")


def _toml(table: Any) -> str:
    if not isinstance(table, dict):
        return f"a = {_inline(table)}\n"
    return "".join(f"{json.dumps(str(k))} = {_inline(v)}\n" for k, v in table.items())


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return (
            "{" + ", ".join(f"{json.dumps(str(k))} = {_inline(v)}" for k, v in value.items()) + "}"
        )
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return json.dumps(value) if isinstance(value, str) else str(value)


def xml_of(content: bytes, rng: random.Random) -> bytes:
    """Elements and attributes lost, doubled, moved and odd, or the text."""
    if not rng.randrange(4):
        return text_of(content, rng)
    if not rng.randrange(60):
        return b"<robot>" + b"<link>" * 50_000
    root = ET.fromstring(content)
    for _ in range(rng.choice((1, 1, 2, 4))):
        elements = list(root.iter())
        one, other = rng.choice(elements), rng.choice(elements)
        kind = rng.randrange(6)
        if kind == 0 and len(one):
            one.remove(rng.choice(list(one)))
        elif kind == 1 and one is not root:
            other.append(copy.deepcopy(one))
        elif kind == 2:
            one.tag = rng.choice((other.tag, "x", "mimic", "mesh"))
        elif one.attrib:
            name = rng.choice(list(one.attrib))
            value = one.attrib.pop(name)
            if kind == 3:
                one.set(rng.choice(("name", "type", "xyz", "link", "joint")), value)
            elif kind == 4:
                text = str(odd.value(rng))
                one.set(name, re.sub("[^\t\n -\ud7ff]", "", text))
            else:
                one.set(name, " ".join(str(rng.choice(odd.NUMBERS)) for _ in range(3)))
    return ET.tostring(root)


def yaml_of(content: bytes, rng: random.Random) -> bytes:
    """A table of YAML, anchors that double one another, or the text."""
    import yaml

    if not rng.randrange(30):
        rows = [
            "a0: &a0 [1.0, 1.0]",
            *(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]" for i in range(1, 40)),
        ]
        key = rng.choice(("k", "d", "intrinsics", "image_width", "distortion_model", "roi"))
        return "\n".join([*rows, f"{key}: *a39", content.decode()]).encode()
    if rng.randrange(2) or content.startswith(b"%"):
        return text_of(content, rng)
    table = tree_of(yaml.safe_load(content), rng)
    return yaml.safe_dump(table).encode("utf-8", "surrogatepass")


def cut_of(content: bytes, rng: random.Random) -> bytes:
    """The first bytes, at times with others at the end or in between."""
    kept = content[: rng.randrange(8, len(content))]
    kind = rng.randrange(4)
    if kind == 0:
        kept += bytes(rng.randrange(1, 5000))
    elif kind == 1:
        kept = bytes_of(kept, rng)
    return kept


def csv_of(content: bytes, rng: random.Random) -> bytes:
    """Columns, rows and cells lost, doubled and odd, or the text."""
    kind = rng.randrange(9)
    if kind == 0:
        return text_of(content, rng)
    if kind == 1:
        return bytes_of(content, rng)
    rows = [line.split(",") for line in content.decode().splitlines()]
    row, column = rng.randrange(len(rows)), rng.randrange(len(rows[0]))
    if kind == 2:
        rows = [[*one[:column], *one[column + 1 :]] for one in rows]
    elif kind == 3:
        rows = [[*one, one[column]] for one in rows]
    elif kind == 4:
        rows = rows[: rng.randrange(len(rows)) + 1]
    elif kind == 5:
        rows[0][column] = rng.choice(odd.TEXTS)
    elif kind == 6:
        same = str(rng.choice(odd.NUMBERS))
        rows = [rows[0], *[[*one[:column], same, *one[column + 1 :]] for one in rows[1:]]]
    elif kind == 7 and not rng.randrange(20):
        rows = [[f"c{i}" for i in range(200_000)], ["0"] * 200_000]
    else:
        rows[row][column] = str(odd.value(rng))
    return "\n".join(",".join(one) for one in rows).encode("utf-8", "surrogatepass")


def parquet_of(content: bytes, rng: random.Random) -> bytes:
    """Columns of other types and lengths, or the bytes."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    if rng.randrange(2):
        return bytes_of(content, rng)
    table = pq.read_table(BytesIO(content))
    names = table.column_names
    at = rng.randrange(len(names))
    n, kind = table.num_rows, rng.randrange(5)
    lists: Any = [[0.5] * rng.randrange(3) for _ in range(n)]
    columns: Any = rng.choice(
        (["x"] * n, [None] * n, [float("nan")] * n, [1e308] * n, [True] * n, lists, [{"a": 1}] * n,
         [b"\xff"] * n, [2**63] * n, list(range(n, 0, -1)))
    )  # fmt: skip
    if kind == 0:
        table = table.remove_column(at)
    elif kind == 1:
        table = table.slice(0, rng.randrange(n))
    elif kind == 2:
        table = table.rename_columns([*names[:at], rng.choice(names), *names[at + 1 :]])
    else:
        made = pa.array(columns, pa.uint64()) if columns[0] == 2**63 else pa.array(columns)
        table = table.set_column(at, names[at], made)
    out = BytesIO()
    pq.write_table(table, out)
    return out.getvalue()


def png_of(content: bytes, rng: random.Random) -> bytes:
    """A header that says something else, with the right sum of check, or the bytes."""
    if rng.randrange(2):
        return bytes_of(content, rng)
    sizes = struct.pack(
        ">II", *(rng.choice((0, 1, 60_000, 2**31 - 1, 2**32 - 1, 17)) for _ in "xy")
    )
    head = (
        b"IHDR" + sizes + bytes([rng.choice((8, 1, 16, 3)), rng.choice((2, 0, 3, 6, 9)), 0, 0, 0])
    )
    return content[:12] + head + struct.pack(">I", zlib.crc32(head)) + content[33:]


MUTATIONS: dict[str, Mutation] = {
    "bytes": bytes_of, "text": text_of, "json": json_of, "toml": toml_of, "xml": xml_of,
    "csv": csv_of, "parquet": parquet_of, "png": png_of, "yaml": yaml_of, "cut": cut_of,
}  # fmt: skip
"""By the word that a reader's seed gives a file."""
