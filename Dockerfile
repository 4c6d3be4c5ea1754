# The command ovman: docker build -t ovman . && docker run --rm -v "$PWD":/data ovman demo
# Not built so far: no container engine was at hand. The environment that it copies has 0.8 GB.
FROM python:3.11-slim AS build
RUN pip install --no-cache-dir 'uv>=0.9'
ENV UV_LINK_MODE=copy UV_PROJECT_ENVIRONMENT=/environment UV_PYTHON_DOWNLOADS=never
WORKDIR /src
COPY . .
# The image has no C++ compiler: the engine's kernels are compiled with Zig's (packages/ovman-engine/setup.py).
RUN uv sync --frozen --no-group dev --no-editable --no-cache

FROM python:3.11-slim
COPY --from=build /environment /environment
ENV PATH=/environment/bin:$PATH HOME=/data
WORKDIR /data
ENTRYPOINT ["ovman"]
