"""What the system's own tables say of processes."""

import os
import subprocess
import time
from pathlib import Path


def _children() -> dict[int, list[int]]:
    """Return the living processes by the one that started them."""
    children: dict[int, list[int]] = {}
    for number in filter(str.isdigit, os.listdir("/proc")):
        try:
            state, parent = (Path("/proc") / number / "stat").read_text().rpartition(")")[2].split()[:2]
        except OSError:
            continue
        if state != "Z":
            children.setdefault(int(parent), []).append(int(number))
    return children


def descendants(pid: int) -> set[int]:
    """Return the living processes that ``pid`` started, and those that they started."""
    children, found, wave = _children(), set(), [pid]
    while wave:
        wave = [child for parent in wave for child in children.get(parent, [])]
        found.update(wave)
    return found


def scene_workers(pid: int) -> list[int]:
    """Return the living processes that make scenes for ``pid``: those that its fork server has forked."""
    children = _children()
    servers = [child for child in children.get(pid, []) if _is_forked(child)]
    # What the server imports may start other programs.
    return sorted(worker for server in servers for worker in children.get(server, []) if _is_forked(worker))


def _is_forked(pid: int) -> bool:
    return "multiprocessing.forkserver" in command_line(pid)


def command_line(pid: int) -> str:
    """Return how a process was started, or nothing if it is gone."""
    try:
        return (Path("/proc") / str(pid) / "cmdline").read_bytes().replace(b"\0", b" ").decode()
    except OSError:
        return ""


def is_alive(pid: int) -> bool:
    """Tell whether a process is there and not merely waiting to be counted."""
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def left_after_kill(process: subprocess.Popen, seconds: float) -> set[int]:
    """Kill a process as the system does when memory runs out; return which of its children live on after a while."""
    children = descendants(process.pid)
    assert children
    process.kill()
    process.wait()
    deadline = time.monotonic() + seconds
    while (left := set(filter(is_alive, children))) and time.monotonic() < deadline:
        time.sleep(0.05)
    return left
