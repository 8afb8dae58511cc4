"""Moving cameras as files hold them: readers of every layout of frames with poses."""
