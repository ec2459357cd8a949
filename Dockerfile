# docker build --tag bodyschema .
# docker run --rm --user "$(id -u):$(id -g)" --volume "$PWD:/data" bodyschema calibrate run.toml
#
# Any user may run it, also one that the image does not know. With --read-only add
# --tmpfs /tmp --tmpfs /var/cache/bodyschema:mode=1777; without the latter each call compiles.

FROM python:3.12-slim AS build
COPY . /src
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels /src

FROM python:3.12-slim
ARG EXTRAS=data,report
RUN --mount=from=build,source=/wheels,target=/wheels \
    pip install --no-cache-dir "$(ls /wheels/*.whl)[${EXTRAS}]"

# What is compiled here serves every processor of this kind, not only that of the builder.
ENV NUMBA_CACHE_DIR=/var/cache/bodyschema \
    NUMBA_CPU_NAME=generic \
    NUMBA_CPU_FEATURES= \
    MPLCONFIGDIR=/var/cache/bodyschema/matplotlib
RUN install -d -m 1777 "$NUMBA_CACHE_DIR" "$MPLCONFIGDIR"

USER 10001
RUN --mount=source=examples,target=/examples \
    python /examples/01_calibrate_points.py \
    && find "$NUMBA_CACHE_DIR" -user 10001 -exec chmod a+rwX {} +

WORKDIR /data
ENTRYPOINT ["bodyschema"]
CMD ["--help"]
