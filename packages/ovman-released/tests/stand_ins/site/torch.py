"""A device has a name."""


class device:
    def __init__(self, name):
        self.name = name

    def __str__(self):
        return self.name


class cuda:
    @staticmethod
    def is_available():
        return False
