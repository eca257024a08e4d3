# docker build -t uniquadric .
# docker run --rm -v "$PWD/out:/uniquadric/out" uniquadric              # the report: out/bench/report.html
# docker run --rm uniquadric scripts/test
FROM debian:bookworm-slim
WORKDIR /uniquadric
COPY . .
RUN bash -c 'source scripts/setup && install_missing packages.txt && build release uniquadric'
CMD ["scripts/bench"]
