"""Let PhysX, with Isaac Sim's reader of USD, hold a stage for 5 s; print, as JSON, bodies, masses and drift."""

import json
import sys
from pathlib import Path

import numpy as np
import ovphysx
import ovstage
from ovphysx import PhysX
from ovphysx.samples.python_samples.schema_support import physx_schema_paths
from ovphysx.types import TensorType

PhysX.set_cpu_mode(True)
engine = PhysX()
ovstage.population.register_usd_schemas([*map(str, physx_schema_paths()), str(ovphysx.newton_schema_root())])
stage = ovstage.Stage("scene")
ovstage.population.open_usd(stage, str(Path(sys.argv[1])), ordinal=1, domains=ovstage.PopulationDomain.ALL)
stage.advance_write_floor(ordinal=1).wait()
engine.wait_task(engine.attach_ovstage(stage, read_ordinal=1))


def read(kind: TensorType) -> np.ndarray:
    binding = engine.create_tensor_binding(pattern="/World/object_*", tensor_type=kind, raise_if_empty=True)
    values = np.zeros(binding.shape, np.float32)
    binding.read(values)
    return values


mass, before = read(TensorType.RIGID_BODY_MASS), read(TensorType.RIGID_BODY_POSE)[:, :3]
for _ in range(300):
    engine.step_sync(1.0 / 60.0)
drift = np.linalg.norm(read(TensorType.RIGID_BODY_POSE)[:, :3] - before, axis=1)
print("RESULT" + json.dumps({"bodies": len(before), "mass": float(mass.sum()), "drift": float(drift.max())}))
