# warehouse-sim from its wheel, with what `make demo` needs, all packages pinned with hashes.
#   docker build -t warehouse-sim .                          for a CPU
#   docker build -t warehouse-sim --build-arg DEVICE=cuda .  for NVIDIA's; run it with --gpus all
#   docker run --rm -v "$PWD/out:/data" warehouse-sim demo --out /data/demo
ARG PYTHON=3.12

FROM python:${PYTHON}-slim-bookworm AS wheel
COPY . /source
RUN pip install --no-cache-dir --require-hashes --no-deps --requirement /source/locks/build.txt
RUN pip wheel --no-cache-dir --no-deps --no-build-isolation --wheel-dir /wheels /source

FROM python:${PYTHON}-slim-bookworm
ARG DEVICE=cpu
RUN apt-get update && apt-get install -y --no-install-recommends libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libgomp1 && rm -rf /var/lib/apt/lists/*
COPY locks /locks
RUN pip install --no-cache-dir --require-hashes --no-deps --only-binary :all: --extra-index-url https://download.pytorch.org/whl/cpu --requirement /locks/torch-${DEVICE}.txt
RUN pip install --no-cache-dir --require-hashes --no-deps --only-binary :all: --requirement /locks/demo.txt
COPY --from=wheel /wheels /wheels
RUN pip install --no-cache-dir --no-deps /wheels/*.whl && warehouse-sim --version
USER 1000:1000
ENV HOME=/tmp
WORKDIR /data
ENTRYPOINT ["warehouse-sim"]
CMD ["--help"]
