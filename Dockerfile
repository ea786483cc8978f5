# graphengine with OpenGL (EGL, Mesa) for cameras, as a user without privileges.
#
#   docker build -t graphengine .
#   docker run --rm -it graphengine                           the demo, without its page
#   docker run --rm -it --network host graphengine graphrun demo    the demo with its page, on the network of the machine
#   docker run --rm graphengine sh tests/all.sh               the tests
FROM python:3.13-slim

RUN apt-get update \
    && apt-get install --yes --no-install-recommends libegl1 libgl1-mesa-dri libopengl0 \
    && rm -rf /var/lib/apt/lists/*
RUN useradd --create-home robot
USER robot
WORKDIR /home/robot/graphengine
COPY --chown=robot . .
RUN python -m venv .venv && .venv/bin/pip install --no-cache-dir '.[view]'
ENV PATH=/home/robot/graphengine/.venv/bin:$PATH
CMD ["graphrun", "demo", "--no-view"]
