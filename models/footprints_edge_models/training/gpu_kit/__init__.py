"""Training within minutes on a rented machine with a GPU, many cores and no network.

A kit, made by ``folder``, brings all that such a machine lacks. There, ``bootstrap`` unpacks it and
starts ``timed_run``: processes make synthetic scenes (``scene_stream``), the GPU keeps every view
(``device_store``), cuts its batches out of them (``device_views``, ``device_colours``) and trains
until the time is up.
"""
