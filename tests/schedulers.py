"""A scheduler shared by tests of several folders."""

import pickle


class Sent:
    """A scheduler that runs calls in this process, pickled as for a worker."""

    def __init__(self, *_):
        pass

    def outcomes(self, calls):
        yield from (pickle.loads(pickle.dumps(call))() for _, call in calls)
