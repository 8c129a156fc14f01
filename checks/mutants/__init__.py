"""What ``checks/mutation.py`` is made of: operators, which tests run which line, processes that judge, equivalents."""
