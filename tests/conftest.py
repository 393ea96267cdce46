from hypothesis import settings

# the first example of a test may compile a kernel
settings.register_profile("hcsearch", deadline=None)
settings.load_profile("hcsearch")
