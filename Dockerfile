# frictool with its kernels compiled:
#   docker build -t frictool . && docker run --rm -v "$PWD":/rig frictool info bench.csv
FROM python:3.11-slim
RUN apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev make && rm -rf /var/lib/apt/lists/*
ENV NUMBA_CACHE_DIR=/opt/kernels
COPY pyproject.toml constraints.txt LICENSE MANIFEST.in /src/
COPY docs/package.md /src/docs/package.md
COPY frictool /src/frictool
RUN pip install --no-cache-dir -c /src/constraints.txt '/src[mdf,parquet,mat73,protobuf]' && rm -rf /src
# compiled for the processor that builds the image; another kind of processor compiles its own at the first use
RUN mkdir -p "$NUMBA_CACHE_DIR" && frictool doctor --compile
WORKDIR /rig
ENTRYPOINT ["frictool"]
CMD ["--help"]
