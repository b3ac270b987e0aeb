#!/usr/bin/env bash
# The MCAP library of PyPI reads a damaged recording as if it were whole.
#
# Version: mcap 1.3.1 (PyPI), Python 3.11.
# Behaviour: `make_reader` does not compare the checksums of chunks unless it is told to (`validate_crcs=True`): one
# changed byte in a message gives another reading, silently. Told to, it still does not compare the checksum of the
# summary section: one changed byte in a channel's name there renames the topic of every message, silently.
# What follows: a recording that "opens fine" in a tool built on it proves nothing; whoever replays or compares recordings
# must check chunks, summary and the number of messages himself.
#
# Output seen on 2026-11-30:
#   whole:                      20 messages on /sonar, the first {"range_m": 1.25, "k": 0}
#   byte of a message, default: 20 messages on /sonar, the first {"range_m": 7.25, "k": 0}
#   the same, validate_crcs:    CRCValidationError
#   byte of the summary, both:  20 messages on /xonar, the first {"range_m": 1.25, "k": 0}
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check mcap==1.3.1
cat >look.py <<'PYTHON'
import io

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer


def recording():
    out = io.BytesIO()
    writer = Writer(out, compression=CompressionType.NONE, chunk_size=1 << 20)
    writer.start(profile="", library="finding")
    schema = writer.register_schema("range", "jsonschema", b"{}")
    channel = writer.register_channel("/sonar", "json", schema)
    for k in range(20):
        writer.add_message(channel, k * 100, b'{"range_m": 1.25, "k": %d}' % k, k * 100)
    writer.finish()
    return out.getvalue()


def read(data, **options):
    try:
        found = [(c.topic, m.data.decode()) for _, c, m in make_reader(io.BytesIO(data), **options).iter_messages()]
    except Exception as error:
        return type(error).__name__
    return f"{len(found)} messages on {found[0][0]}, the first {found[0][1]}"


def changed(data, at, byte):
    return data[:at] + byte + data[at + 1 :]


whole = recording()
message = changed(whole, whole.index(b"1.25"), b"7")
summary = changed(whole, whole.rindex(b"/sonar") + 1, b"x")
first = '20 messages on /sonar, the first {"range_m": 1.25, "k": 0}'
for name, found, expected in [
    ("whole", read(whole), first),
    ("byte of a message, default", read(message), first.replace("1.25", "7.25")),
    ("the same, validate_crcs", read(message, validate_crcs=True), "CRCValidationError"),
    ("byte of the summary, default", read(summary), first.replace("/sonar", "/xonar")),
    ("the same, validate_crcs", read(summary, validate_crcs=True), first.replace("/sonar", "/xonar")),
]:
    print(f"{name}: {found}")
    assert found == expected, f"{name}: this has changed; expected {expected}"
PYTHON
env/bin/python look.py
