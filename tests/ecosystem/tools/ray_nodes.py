"""Make a dataset on a Ray cluster of two nodes on loopback, one of which is lost meanwhile, and in one process."""

import json
import os
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, sys.argv[2])  # this package; that of others comes after it

import ray
from ray.cluster_utils import Cluster

from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.ray_cluster import generate_on_ray, merge_packed
from warehouse_sim.generation.recipe import load_recipe

folder, root = Path(sys.argv[1]), Path(sys.argv[2])
os.environ["PYTHONPATH"] = str(root)
recipe, config = load_recipe("smoke"), GenerateConfig(scenes=4, seed=3)
memory = {"object_store_memory": 100 << 20, "include_dashboard": False}
cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, **memory})
second = cluster.add_node(num_cpus=1, object_store_memory=100 << 20)
ray.init(address=cluster.address, log_to_driver=False)
nodes = sum(node["Alive"] for node in ray.nodes())
shards, lost = folder / "shards", []


def lose_a_node() -> None:
    while not list(shards.glob("*.tar")):
        time.sleep(0.05)
    cluster.remove_node(second, allow_graceful=False)
    lost.append(len(list(shards.glob("*.tar"))))


killer = threading.Thread(target=lose_a_node, daemon=True)
killer.start()
generate_on_ray(recipe, f"file://{shards}", config)
killer.join(60)
left = sum(node["Alive"] for node in ray.nodes())
before = {path.name: path.stat().st_mtime_ns for path in shards.iterdir()}
generate_on_ray(recipe, f"file://{shards}", config)
ray.shutdown()
cluster.shutdown()
merge_packed(f"file://{shards}", folder / "cluster")
generate(recipe, folder / "serial", config)
again = before == {path.name: path.stat().st_mtime_ns for path in shards.iterdir()}
print(json.dumps({"nodes": nodes, "left": left, "lost_after": lost, "shards": sorted(before), "kept": again}))
