"""What `--executor` takes."""

EXECUTORS = "serial, threads:N, processes:N or dask:ADDRESS (of the scheduler of a Dask cluster) (default: %(default)s)"
