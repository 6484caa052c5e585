def startup():
    pass
