"""Make a dataset by ``generate --on`` on a Ray cluster of two nodes on loopback, one of which is lost meanwhile.

two_nodes.py FOLDER file|s3|client|gone

file: the shards lie in a folder; s3: in a bucket of a server on loopback; client: the command is a client of the
cluster (``ray://``), in a process of its own; gone: the connection ends while scenes are made.
"""

import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import fsspec
import ray
from ray.cluster_utils import Cluster

from warehouse_sim.cli.main import main

folder, mode = Path(sys.argv[1]), sys.argv[2]
# Ray's workers give way to all else that runs here, and on a busy machine then come to nothing.
os.environ["RAY_worker_niceness"] = "0"  # noqa: SIM112  its name
if mode == "s3":
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    os.environ |= {
        "AWS_ENDPOINT_URL": "http://{}:{}".format(*server.get_host_and_port()),
        "AWS_ACCESS_KEY_ID": "nobody",
        "AWS_SECRET_ACCESS_KEY": "nothing",
        "AWS_DEFAULT_REGION": "us-east-1",
    }
    fsspec.filesystem("s3").mkdir("shards")
place = "s3://shards/data" if mode == "s3" else f"file://{folder / 'shards'}"
ours = {"include_dashboard": False, **({"ray_client_server_port": 20001} if mode == "client" else {})}
memory = {"object_store_memory": 100 << 20}
# The driver is attached to the head, the only node so far: the other one can go.
cluster = Cluster(initialize_head=True, connect=mode != "client", head_node_args={"num_cpus": 1, **memory, **ours})
second = cluster.add_node(num_cpus=1, **memory)
lost: list[int] = []


def stored() -> dict[str, str]:
    """Return when each archive was stored."""
    files, path = fsspec.core.url_to_fs(place)
    files.invalidate_cache()
    found = files.find(path, detail=True) if files.exists(path) else {}
    times = {Path(name).name: str(item.get("LastModified") or item.get("mtime")) for name, item in found.items()}
    return {name: when for name, when in times.items() if name.endswith(".tar")}


def lose() -> None:
    """Take a node away, or the connection, once something is stored."""
    while not stored():
        time.sleep(0.2)
    if mode == "gone":
        ray.shutdown()
    else:
        cluster.remove_node(second, allow_graceful=False)
    lost.append(len(stored()))


def generate() -> int:
    """Return what the command ends with."""
    on = "ray://127.0.0.1:20001" if mode == "client" else "ray"
    words = ["generate", "smoke", "--scenes", "4", "--seed", "3", "--out", str(folder / "cluster"), "--overwrite"]
    words += ["--on", on, "--shards", place]
    if mode == "client":
        return subprocess.run([sys.executable, "-m", "warehouse_sim", *words], check=False).returncode
    return main(words)


killer = threading.Thread(target=lose, daemon=True)
killer.start()
first = generate()
killer.join(60)
before = stored()
again = -1 if mode == "gone" else generate()
found = {"lost_after": lost, "ended": [first, again], "shards": sorted(before), "kept": before == stored()}
(folder / "said.json").write_text(json.dumps(found))
ray.shutdown()
cluster.shutdown()
