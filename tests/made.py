"""Values by name, each made when it is first asked for: a test process pays for those of its own tests."""

from collections.abc import Mapping


class Made(Mapping):
    def __init__(self, **makers):
        self._makers, self._made = makers, {}

    def __getitem__(self, name):
        if name not in self._made:
            self._made[name] = self._makers[name]()
        return self._made[name]

    def __iter__(self):
        return iter(self._makers)

    def __len__(self):
        return len(self._makers)
