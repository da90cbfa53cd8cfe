"""Reader of ROS 2 bags in SQLite files (`.db3`).

The database has the tables `topics` and `messages` and, since ROS 2 Iron, a table with the
definitions of the messages.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path

from frictool.errors import LogError
from frictool.logs.open_file import open_log
from frictool.logs.recordings.decoders import topic_of
from frictool.logs.recordings.recording import SAMPLED, MessageGap, Topic
from frictool.logs.recordings.serialised_messages import Messages, pack_messages

MAGIC = b"SQLite format 3\0"
LARGEST_MESSAGE = 64_000_000  # bytes, maximum size of a message
LONGEST_ROW = 120  # maximum number of characters of a database row in an error message
AT_ONCE_BYTES = 1_000_000  # maximum number of bytes of a batch
AT_ONCE_ROWS = 4096  # maximum number of rows of a batch


class Db3Recording:
    """ROS 2 bag in an SQLite file (implements RecordingFile)."""

    def __init__(self, path: Path) -> None:
        """Open the file and read its topics; raise LogError if the file is not a readable bag."""
        open_log(path).close()
        self.source = str(path)
        self._path = path
        self.size = path.stat().st_size
        self.topics: dict[str, Topic] = {}
        self._numbers: dict[str, list[int]] = {}  # topic -> its ids in the bag
        try:
            with closing(self._connection()) as bag:
                self._look(bag)
        except (sqlite3.Error, OverflowError, UnicodeDecodeError) as error:
            raise LogError(path, f"is not a ROS 2 bag, or is damaged: {error}") from None

    def _connection(self) -> sqlite3.Connection:
        """Return a read-only connection that neither takes a lock nor reads or writes a journal."""
        bag = sqlite3.connect(f"{self._path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
        bag.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_MESSAGE)
        bag.execute("PRAGMA trusted_schema = OFF")
        # lets SQLite read the rows of a truncated file; nothing is written
        bag.execute("PRAGMA writable_schema = ON")
        bag.text_factory = lambda data: data.decode("utf-8", "replace")
        return bag

    def _missing(self) -> int:
        with open_log(self._path) as stream:
            head = stream.read(100)
        page = int.from_bytes(head[16:18], "big")
        # if an old library wrote the file last, the two change counters differ and the page
        # count is wrong
        known = head[24:28] == head[92:96]
        return (
            max(0, (65536 if page == 1 else page) * int.from_bytes(head[28:32], "big") - self.size)
            if known
            else 0
        )

    def _look(self, bag: sqlite3.Connection) -> None:
        tables = {
            name for (name,) in bag.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
        }
        if not {"topics", "messages"} <= tables:
            raise LogError(
                self._path,
                "is an SQLite file but not a ROS 2 bag: it lacks the tables topics and messages; "
                f"found: {sorted(tables)}",
            )
        definitions: dict[str, tuple[str, str]] = {}
        if "message_definitions" in tables:
            rows = bag.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            )
            definitions = {str(kind): (str(form), str(text)) for kind, form, text in rows}
        for row in bag.execute(
            "SELECT id, name, type, serialization_format FROM topics"
        ).fetchall():
            number, name, kind, encoding = row
            if not isinstance(number, int) or not all(isinstance(text, str) for text in row[1:]):
                raise sqlite3.DataError(
                    f"a row of its table 'topics' is {str(row)[:LONGEST_ROW]}; allowed: "
                    "a number and three texts"
                )
            form, text = definitions.get(kind, ("ros2msg", ""))
            topic = self.topics.setdefault(
                name, topic_of(self._path, name, kind, encoding, form, text.encode())
            )
            self._numbers.setdefault(topic.name, []).append(number)
            with suppress(sqlite3.Error):  # reported when the messages are read
                topic.sample(
                    next(
                        (piece for piece, _ in self._read(bag, topic.name, SAMPLED)),
                        pack_messages([], []),
                    )
                )

    def messages(self, topic: str) -> Iterator[tuple[Messages | MessageGap, int]]:
        """Yield the messages and the gaps between them (see RecordingFile)."""
        journal = self._path.with_name(f"{self._path.name}-wal")
        if journal.is_file() and journal.stat().st_size:
            yield (
                MessageGap(
                    f"was not closed: {journal.name} in its folder contains messages; `sqlite3 "
                    f"{self._path.name} vacuum` adds them to the bag"
                ),
                0,
            )
        if missing := self._missing():
            yield (
                MessageGap(
                    f"is cut off: it has {self.size} bytes, but declares {self.size + missing}"
                ),
                0,
            )
        try:
            with closing(self._connection()) as bag:
                yield from self._read(bag, topic)
        except (sqlite3.Error, OverflowError) as error:
            yield MessageGap(f"is damaged or cut off: {error}"), self.size

    def _read(
        self, bag: sqlite3.Connection, topic: str, most: int = -1
    ) -> Iterator[tuple[Messages, int]]:
        """Yield messages of a topic in the order of recording.

        Raises sqlite3.Error after the last readable message.
        """
        numbers = self._numbers[topic]
        marks = ", ".join("?" * len(numbers))
        query = (
            f"SELECT rowid, timestamp, data FROM messages WHERE topic_id IN ({marks}) ORDER BY "
            "rowid LIMIT ?"
        )
        rows = bag.execute(query, (*numbers, most))
        done = 0
        for part in _batches(rows):
            done += sum(len(row[2]) for row in part if isinstance(row[2], bytes))
            bad = [
                row
                for row in part
                if not isinstance(row[1], int) or row[1] < 0 or not isinstance(row[2], bytes)
            ]
            if bad:
                raise sqlite3.DataError(
                    f"row {bad[0][0]} of its table 'messages' has no valid time or no content"
                )
            yield (
                pack_messages([row[1] for row in part], [row[2] for row in part]),
                min(done, self.size),
            )


def _batches(rows: Iterator[tuple[int, int, bytes]]) -> Iterator[list[tuple[int, int, bytes]]]:
    """Yield rows in batches; if `rows` raises an error, first yield the rows before the error."""
    part: list[tuple[int, int, bytes]] = []
    size = 0
    try:
        for row in rows:
            part.append(row)
            size += len(row[2]) if isinstance(row[2], bytes) else 0
            if size > AT_ONCE_BYTES or len(part) >= AT_ONCE_ROWS:
                yield part
                part = []
                size = 0
    except sqlite3.Error:
        if part:
            yield part
        raise
    if part:
        yield part
