"""The doctor says what is there, and fails when something needed is not."""

from __future__ import annotations

import json
from typing import Any

import pytest
from rover.cli import doctor


@pytest.fixture
def checks(rover) -> dict[str, dict[str, Any]]:
    result = rover("doctor", "--json")
    listed = json.loads(result.out)["checks"]
    assert result.code == (0 if all(check["ok"] for check in listed) else 3)
    return {check["name"]: check for check in listed}


def test_json_lists_name_ok_and_detail(checks):
    assert all(set(check) == {"name", "ok", "detail"} and check["detail"] for check in checks.values())
    needed = {"python", "numpy", "cv2", "onnxruntime", "ruckig", "serial", "can", "mcap", "rover_native", "rover_plant"}
    assert needed | {"model", "rover-sitl", "firmware toolchain", "serial ports", "cameras", "CAN interfaces"} == set(
        checks
    )
    assert checks["numpy"]["ok"]
    assert "sha256" in checks["model"]["detail"]


def test_a_missing_rig_binary_fails_with_exit_code_3(rover, monkeypatch, tmp_path):
    monkeypatch.setenv("ROVER_SITL", str(tmp_path / "none"))
    result = rover("doctor")
    assert result.code == 3
    assert [line for line in result.out.splitlines() if line.startswith("FAILED rover-sitl")]


def test_a_missing_package_is_told_with_the_remedy(monkeypatch):
    monkeypatch.setattr(doctor, "PACKAGES", (("no_such_module", "no-such-module"),))
    check = next(check for check in doctor.examine() if check.name == "no_such_module")
    assert not check.ok
    assert "make setup" in check.detail


def test_a_firmware_toolchain_is_optional(monkeypatch):
    monkeypatch.setattr(doctor.shutil, "which", lambda _: None)
    check = next(check for check in doctor.examine() if check.name == "firmware toolchain")
    assert check.ok
    assert "only needed to build the firmware" in check.detail


def test_a_port_without_a_rover_fails(rover):
    result = rover("doctor", "--port", "/dev/no-such-port", "--json")
    last = json.loads(result.out)["checks"][-1]
    assert (result.code, last["name"], last["ok"]) == (3, "firmware", False)
