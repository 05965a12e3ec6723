namespace onemap {}
