"""Drive a truck into the pockets of a pallet: docking as an environment of gymnasium.

python examples/10_docking_task.py      # pip install "warehouse-sim[gym]"
"""

from pathlib import Path

import cv2
import gymnasium
import numpy as np

import warehouse_sim.gym
from warehouse_sim.gym.agents import PursuitAgent

env = gymnasium.make(warehouse_sim.gym.ENVIRONMENT, recipe="smoke", observes="poses", render_mode="rgb_array")
agent = PursuitAgent()  # yours takes its place
seen, known = env.reset(seed=0)
agent.begin(known)
frames, total, ended, truncated = [env.render()], 0.0, False, False
while not ended and not truncated:
    seen, reward, ended, truncated, info = env.step(agent.act(seen))
    total += reward
frames.append(env.render())  # the camera between the tips, before they went in
env.close()
print(f"{info.get('outcome', 'timed out')} after {seen[-1]:.1f} s, reward {total:.2f}")
Path("out/examples").mkdir(parents=True, exist_ok=True)
cv2.imwrite("out/examples/10_docking_task.png", np.vstack(frames)[..., ::-1])
