"""Make a dataset on a Ray cluster of two nodes on loopback, one of which is lost meanwhile, and in one process.

ray_nodes.py FOLDER CHECKOUT file|s3     # s3: the shards lie in a bucket of a server on loopback
"""

import json
import os
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, sys.argv[2])  # this package; that of others comes after it

import fsspec
import ray
from ray.cluster_utils import Cluster

from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.ray_cluster import generate_on_ray, merge_packed
from warehouse_sim.generation.recipe import load_recipe

folder, root = Path(sys.argv[1]), Path(sys.argv[2])
os.environ["PYTHONPATH"] = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
# Ray's workers give way to all else that runs here, and on a busy machine then come to nothing.
os.environ["RAY_worker_niceness"] = "0"  # noqa: SIM112  its name
if sys.argv[3] == "s3":
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
place = "s3://shards/data" if sys.argv[3] == "s3" else f"file://{folder / 'shards'}"
recipe, config = load_recipe("smoke"), GenerateConfig(scenes=4, seed=3)
memory = {"object_store_memory": 100 << 20, "include_dashboard": False}
cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, **memory})
second = cluster.add_node(num_cpus=1, object_store_memory=100 << 20)
ray.init(address=cluster.address, log_to_driver=False)
nodes = sum(node["Alive"] for node in ray.nodes())
lost: list[int] = []


def stored() -> dict[str, str]:
    """Return when each archive was stored."""
    files, path = fsspec.core.url_to_fs(place)
    files.invalidate_cache()
    found = files.ls(path, detail=True) if files.exists(path) else []
    times = {Path(item["name"]).name: str(item.get("LastModified") or item.get("mtime")) for item in found}
    return {name: when for name, when in times.items() if name.endswith(".tar")}


def lose_a_node() -> None:
    while not stored():
        time.sleep(0.2)
    cluster.remove_node(second, allow_graceful=False)
    lost.append(len(stored()))


killer = threading.Thread(target=lose_a_node, daemon=True)
killer.start()
generate_on_ray(recipe, place, config)
killer.join(60)
left = sum(node["Alive"] for node in ray.nodes())
before = stored()
generate_on_ray(recipe, place, config)
ray.shutdown()
cluster.shutdown()
merge_packed(place, folder / "cluster")
generate(recipe, folder / "serial", config)
again = before == stored()
print(json.dumps({"nodes": nodes, "left": left, "lost_after": lost, "shards": sorted(before), "kept": again}))
