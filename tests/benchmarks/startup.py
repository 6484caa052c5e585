def startup(): pass
