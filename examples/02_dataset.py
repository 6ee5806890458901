"""A small dataset in two formats, made, checked and read again.

python examples/02_dataset.py
"""

import warehouse_sim as ws

data = ws.generate("smoke", "out/examples/dataset", scenes=2, seed=0, formats=["bop", "coco"], overwrite=True)
print(data.name, {name: len(data.split(name)) for name in data.splits})
print("checks that failed:", [check.name for check in ws.validate("out/examples/dataset") if not check.ok])
obs = data[0]
print(f"image {obs.rgb.shape}, {len(obs.points)} points, {len(obs.objects)} objects with labels")
obs.draw("out/examples/02_dataset.png")
