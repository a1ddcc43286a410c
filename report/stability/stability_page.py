from shared.page_parts import PageParts


def page_parts(run, *found):
    return PageParts("TODO")
