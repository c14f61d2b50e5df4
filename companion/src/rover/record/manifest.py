"""What a run's folder held when the run ended: every file with its SHA-256, signed by the operator if he has a key.

A manifest without a signature tells damage from wholeness; only a signature by a known key tells that nobody has
changed a file and its hash together.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from rover.errors import BadInput
from rover.plain_file import plain_file
from rover.record.strict_json import document

MANIFEST = "manifest.json"
SIGNATURE = "manifest.sig"
VERSION = 1
BLOCK = 1 << 20
# A manifest of a million files.
MAX_BYTES = 200_000_000


@dataclass(frozen=True)
class FileCheck:
    """A file of a manifest. why: what is wrong with it, "" when it is as it was."""

    name: str
    why: str

    @property
    def ok(self) -> bool:
        """True for a file that is as the run left it."""
        return not self.why


@dataclass(frozen=True)
class Verified:
    """A folder held against its manifest.

    signature: "none", "valid" or "invalid"; key: fingerprint of the key that signed. trusted: by the key that was
    asked for, None when none was. added: files that came later, or that the manifest leaves out.
    """

    files: tuple[FileCheck, ...]
    signature: str
    key: str
    trusted: bool | None
    added: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """True when every file is as it was, and no signature says otherwise."""
        return all(file.ok for file in self.files) and self.signature != "invalid" and self.trusted is not False


def manifest_bytes(folder: Path, names: Iterable[str]) -> bytes:
    """The manifest of those of the files `names` that are there. Raises OSError."""
    rows = []
    for name in sorted(names):
        file = folder / name
        if file.is_file():
            rows.append({"name": name, "bytes": file.stat().st_size, "sha256": _sha256(file)})
    return document({"version": VERSION, "files": rows}, indent=1).encode()


def signature_bytes(manifest: bytes, key: Ed25519PrivateKey) -> bytes:
    """Content of the file of the signature."""
    public = key.public_key()
    signed = {
        "algorithm": "ed25519",
        "public_key": base64.b64encode(_raw(public)).decode(),
        "fingerprint": fingerprint(public),
        "signature": base64.b64encode(key.sign(manifest)).decode(),
    }
    return document(signed, indent=1).encode()


def verify(folder: Path, trusted: Ed25519PublicKey | None = None) -> Verified:
    """Raises BadInput for a folder without a manifest, or with one that is damaged beyond reading."""
    content = _read(folder / MANIFEST)
    try:
        rows = [(str(row["name"]), str(row["sha256"])) for row in json.loads(content)["files"]]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise BadInput(f"{folder / MANIFEST}: damaged: not a manifest") from None
    files = tuple(FileCheck(name, _wrong(folder, name, digest)) for name, digest in rows)
    signature, signer = _signature(folder, content)
    known = {name for name, _ in rows} | {MANIFEST, SIGNATURE}
    added = tuple(sorted(entry.name for entry in folder.iterdir() if entry.name not in known))
    is_trusted = None
    if trusted is not None:
        is_trusted = signature == "valid" and signer is not None and _raw(signer) == _raw(trusted)
    return Verified(files, signature, "" if signer is None else fingerprint(signer), is_trusted, added)


def private_key(path: Path) -> Ed25519PrivateKey:
    """An Ed25519 key as PEM (openssl genpkey) or as ssh-keygen writes it. Raises BadInput."""
    data = _read(path)
    load = (
        serialization.load_ssh_private_key if b"OPENSSH PRIVATE KEY" in data else serialization.load_pem_private_key
    )
    try:
        key = load(data, password=None)
    except TypeError:
        raise BadInput(f"{path}: the key is locked with a password; give one without, as for a machine") from None
    except (ValueError, UnsupportedAlgorithm):
        raise BadInput(f"{path}: not a private key; make one with: openssl genpkey -algorithm ed25519") from None
    if not isinstance(key, Ed25519PrivateKey):
        raise BadInput(f"{path}: the key is of another kind; Ed25519 is wanted")
    return key


def public_key(path: Path) -> Ed25519PublicKey:
    """As PEM (openssl pkey -pubout), or a line of ssh-keygen. Raises BadInput."""
    data = _read(path)
    load = serialization.load_ssh_public_key if data.startswith(b"ssh-") else serialization.load_pem_public_key
    try:
        key = load(data)
    except (ValueError, UnsupportedAlgorithm):
        raise BadInput(f"{path}: not a public key; openssl pkey -in KEY -pubout writes one") from None
    if not isinstance(key, Ed25519PublicKey):
        raise BadInput(f"{path}: the key is of another kind; Ed25519 is wanted")
    return key


def fingerprint(key: Ed25519PublicKey) -> str:
    """Short name of a key, to compare by eye."""
    return hashlib.sha256(_raw(key)).hexdigest()[:16]


def _signature(folder: Path, manifest: bytes) -> tuple[str, Ed25519PublicKey | None]:
    if not (folder / SIGNATURE).exists():
        return "none", None
    try:
        signed = json.loads(_read(folder / SIGNATURE))
        key = Ed25519PublicKey.from_public_bytes(base64.b64decode(signed["public_key"], validate=True))
        key.verify(base64.b64decode(signed["signature"], validate=True), manifest)
    except (ValueError, KeyError, TypeError, RecursionError, binascii.Error, InvalidSignature, BadInput):
        return "invalid", None
    return "valid", key


def _wrong(folder: Path, name: str, digest: str) -> str:
    # A manifest from elsewhere must not make anybody read files beside the folder.
    if Path(name).name != name or name in ("", ".", ".."):
        return "is no name of a file in this folder"
    file = folder / name
    try:
        if not plain_file(file).is_file():
            return "is missing"
        return "" if _sha256(file) == digest else "has changed"
    except BadInput:
        return "is no plain file"
    except OSError as error:
        return f"cannot be read: {error.strerror or error}"


def _sha256(file: Path) -> str:
    digest = hashlib.sha256()
    with file.open("rb") as stream:
        while block := stream.read(BLOCK):
            digest.update(block)
    return digest.hexdigest()


def _read(path: Path) -> bytes:
    try:
        if plain_file(path).stat().st_size > MAX_BYTES:
            raise BadInput(f"{path}: too large")
        return path.read_bytes()
    except FileNotFoundError:
        raise BadInput(f"{path}: no such file") from None
    except OSError as error:
        raise BadInput(f"{path}: cannot be read: {error.strerror or error}") from error


def _raw(key: Ed25519PublicKey) -> bytes:
    return key.public_bytes(serialization.Encoding.Raw, serialization.PublicFormat.Raw)
