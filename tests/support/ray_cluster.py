"""A Ray cluster of two worker processes on this machine."""

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def two_workers(*folders: Path) -> Iterator[None]:
    """The cluster, while the block runs; its workers import from `folders`, too."""
    import ray

    paths = filter(None, [*map(str, folders), os.environ.get("PYTHONPATH")])
    ray.init(
        num_cpus=2,
        include_dashboard=False,
        log_to_driver=False,
        object_store_memory=100 * 2**20,
        logging_level=logging.ERROR,
        runtime_env={"env_vars": {"PYTHONPATH": os.pathsep.join(paths)}},
    )
    yield
    ray.shutdown()
