# weftex: the command line and, with "studio", the page in a browser.
#
#   docker build -t weftex .
#   docker run --rm -v "$PWD:/work" weftex synth sample:pebbles -o pebbles.png --size 1k
#   docker run --rm -v "$PWD:/work" -p 127.0.0.1:8427:8427 weftex studio --host 0.0.0.0 --no-browser
FROM python:3.13.13-slim-bookworm@sha256:355bfa66770995d7e9a0da4b3473b44d0cb451f6b56f5615ad9c39e3c4eca03f AS build
RUN apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /src
COPY . .
RUN pip install --no-cache-dir --require-hashes --only-binary :all: -r .github/build-requirements.txt \
    && WEFTEX_ABI3=1 pip wheel --no-cache-dir --no-build-isolation --no-deps -w /wheels .

FROM python:3.13.13-slim-bookworm@sha256:355bfa66770995d7e9a0da4b3473b44d0cb451f6b56f5615ad9c39e3c4eca03f
COPY --from=build /wheels /wheels
RUN pip install --no-cache-dir "$(echo /wheels/*.whl)[kdtree,materialx,studio]" && rm -rf /wheels \
    && useradd --create-home weftex
USER weftex
WORKDIR /work
ENTRYPOINT ["weftex"]
CMD ["--help"]
