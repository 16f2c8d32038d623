"""Damage to files: flipped, cut, doubled and zeroed bytes, and numbers that no reader hopes for."""
import re

NUMBERS = [b"nan", b"-nan", b"inf", b"1e400", b"-1", b"0", b"1e-320", b"4294967296", b"18446744073709551616", b"2147483647", b"-2147483648", b"1,5", b"0x10",
           b"1e308", b"99999999999999999999999999", b"", b"--3", b"1.2.3"]


def flipped(content, random):
    out = bytearray(content)
    for _ in range(random.choice((1, 1, 2, 4, 16))):
        out[random.randrange(len(out))] ^= 1 << random.randrange(8)
    return bytes(out)


def cut(content, random):
    return content[:random.randrange(len(content))]


def spliced(content, random):
    """A stretch is left out, doubled, zeroed or moved."""
    length = min(len(content) - 1, random.choice((1, 2, 4, 16, 100, 1000)))
    at = random.randrange(len(content) - length)
    piece, rest = content[at:at + length], content[:at] + content[at + length:]
    way = random.randrange(4)
    if way == 0:
        return rest
    if way == 1:
        return content[:at] + piece + piece + content[at + length:]
    if way == 2:
        return content[:at] + bytes(length) + content[at + length:]
    to = random.randrange(len(rest) + 1)
    return rest[:to] + piece + rest[to:]


def numbered(content, random):
    """In texts some numbers become others; in binary files a word of four bytes is set."""
    places = [found.span() for found in re.finditer(rb"-?\d+(\.\d+)?([eE][-+]?\d+)?", content)] if b"\0" not in content[:4000] else []
    if not places:
        at = random.randrange(max(1, len(content) - 4))
        return content[:at] + random.choice((b"\xff\xff\xff\xff", b"\0\0\0\0", b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\xc0\x7f")) + content[at + 4:]
    for low, high in sorted(random.sample(places, min(len(places), random.choice((1, 1, 3)))), reverse=True):
        content = content[:low] + random.choice(NUMBERS) + content[high:]
    return content


WAYS = {"bytes flipped": flipped, "cut short": cut, "stretch moved": spliced, "numbers replaced": numbered}
