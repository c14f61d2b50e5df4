"""A run's files are held against what they were, and against the operator's key."""

from __future__ import annotations

import base64
import json
import subprocess
from pathlib import Path

import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.record.manifest import (
    MANIFEST,
    SIGNATURE,
    manifest_bytes,
    private_key,
    public_key,
    signature_bytes,
    verify,
)

NAMES = ("report.html", "summary.json", "mission.mcap")
PEM, PKCS8 = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8


@pytest.fixture
def key() -> Ed25519PrivateKey:
    return Ed25519PrivateKey.from_private_bytes(bytes(range(32)))


@pytest.fixture
def run(tmp_path: Path, key: Ed25519PrivateKey) -> Path:
    folder = tmp_path / "run"
    folder.mkdir()
    for name in NAMES:
        (folder / name).write_text(name * 3)
    manifest = manifest_bytes(folder, [*NAMES, "truth.tum"])
    (folder / MANIFEST).write_bytes(manifest)
    (folder / SIGNATURE).write_bytes(signature_bytes(manifest, key))
    return folder


def saved(key: Ed25519PrivateKey, path: Path) -> Path:
    path.write_bytes(key.public_key().public_bytes(PEM, serialization.PublicFormat.SubjectPublicKeyInfo))
    return path


def test_a_run_as_it_was_left_is_ok_and_signed(run, key):
    found = verify(run, key.public_key())
    assert (found.ok, found.signature, found.trusted, found.added) == (True, "valid", True, ())
    assert [file.name for file in found.files] == sorted(NAMES)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60, deadline=None)
@given(st.sampled_from((*NAMES, MANIFEST, SIGNATURE)), st.integers(0, 10_000), st.integers(0, 7))
def test_no_flipped_bit_goes_unnoticed(run, key, name, place, bit):
    file = run / name
    whole = file.read_bytes()
    damaged = bytearray(whole)
    damaged[place % len(damaged)] ^= 1 << bit
    file.write_bytes(bytes(damaged))
    try:
        # Blanks and the key's printed name in the file of the signature say nothing: there the rest must still hold.
        found = verify(run, key.public_key())
        assert not found.ok or (name == SIGNATURE and found.signature == "valid")
    except BadInput:  # it says itself that it is damaged
        assert name == MANIFEST
    finally:
        file.write_bytes(whole)


def test_what_is_missing_and_what_came_later_is_told_apart(run, key):
    (run / "report.html").unlink()
    (run / "judgements.jsonl").write_text("{}")
    found = verify(run)
    assert [(file.name, file.why) for file in found.files if not file.ok] == [("report.html", "is missing")]
    assert found.added == ("judgements.jsonl",)


def test_whoever_changes_file_and_manifest_together_cannot_sign_it(run, key):
    (run / "summary.json").write_text("nothing was found")
    forged = manifest_bytes(run, NAMES)
    (run / MANIFEST).write_bytes(forged)
    assert verify(run).signature == "invalid"
    other = Ed25519PrivateKey.from_private_bytes(bytes(32))
    (run / SIGNATURE).write_bytes(signature_bytes(forged, other))
    assert verify(run).signature == "valid"
    assert verify(run, key.public_key()).trusted is False
    (run / SIGNATURE).unlink()
    assert not verify(run, key.public_key()).ok


@pytest.mark.parametrize("name", ["../outside", "/etc/hostname", "", "..", "a/b"])
def test_a_manifest_reaches_no_file_beside_its_folder(run, name):
    (run / MANIFEST).write_text(json.dumps({"version": 1, "files": [{"name": name, "sha256": "0"}]}))
    assert [file.why for file in verify(run).files] == ["is no name of a file in this folder"]


def test_keys_of_openssl_and_of_ssh_are_read_and_others_refused(tmp_path, key):
    (tmp_path / "pem").write_bytes(key.private_bytes(PEM, PKCS8, serialization.NoEncryption()))
    ssh = key.private_bytes(PEM, serialization.PrivateFormat.OpenSSH, serialization.NoEncryption())
    (tmp_path / "ssh").write_bytes(ssh)
    for name in ("pem", "ssh"):
        assert private_key(tmp_path / name).private_bytes_raw() == key.private_bytes_raw()
    locked = key.private_bytes(PEM, PKCS8, serialization.BestAvailableEncryption(b"x"))
    (tmp_path / "locked").write_bytes(locked)
    (tmp_path / "text").write_text("hello")
    for name, says in (("locked", "locked with a password"), ("text", "not a private key"), ("none", "no such file")):
        with pytest.raises(BadInput, match=says):
            private_key(tmp_path / name)
    with pytest.raises(BadInput, match="not a public key"):
        public_key(tmp_path / "text")


def test_openssl_agrees_with_the_signature(run, key, tmp_path):
    """A peer: the signature is a plain Ed25519 one over the bytes of the manifest."""
    raw = base64.b64decode(json.loads((run / SIGNATURE).read_text())["signature"])
    (tmp_path / "raw").write_bytes(raw)
    command = ["openssl", "pkeyutl", "-verify", "-pubin", "-inkey", str(saved(key, tmp_path / "pub")), "-rawin"]
    done = subprocess.run(
        [*command, "-in", str(run / MANIFEST), "-sigfile", str(tmp_path / "raw")], capture_output=True, text=True
    )
    assert "Signature Verified Successfully" in done.stdout + done.stderr
