' Formula wizard and Write wizard: choose items that the gateway has; formulas or write cells for them.
Option Explicit

Global gDialog As Object
Global gFound As Variant
Global gWritable As Boolean

Const MOST = 500

Sub FormulaWizard
	' Formulas for the chosen items, from the cell downwards where the cursor is.
	Dim aItems As Variant, oAt As Object, sWhat As String, sWhy As String
	oAt = CursorCell()
	If IsNull(oAt) Then Exit Sub
	aItems = Chosen("Formula wizard", "Formulas go to " & CellName(oAt) & " and the cells below and beside it.", False, sWhat)
	If UBound(aItems) < 0 Then Exit Sub
	sWhy = InsertFormulas(oAt, aItems, sWhat)
	If sWhy <> "" Then MsgBox(sWhy, 48, "pcaccess")
End Sub

Sub WriteWizard
	' A row with a write cell for each chosen item, on the sheet Write.
	Dim aItems As Variant, sWhat As String, sWhy As String
	aItems = Chosen("Write wizard", "Each item gets a row with a yellow cell on the sheet " & WRITE_SHEET & ".", True, sWhat)
	If UBound(aItems) < 0 Then Exit Sub
	sWhy = AddWriteRows(aItems)
	If sWhy <> "" Then MsgBox(sWhy, 48, "pcaccess")
	ThisComponent.CurrentController.setActiveSheet(ThisComponent.Sheets.getByName(WRITE_SHEET))
End Sub

Function CursorCell() As Object
	Dim oSelected As Object
	oSelected = ThisComponent.CurrentSelection
	If oSelected.supportsService("com.sun.star.sheet.SheetCellRange") Then
		CursorCell = oSelected.getCellByPosition(0, 0)
	Else
		MsgBox("Put the cursor into the cell where the formulas shall begin.", 48, "pcaccess")
		CursorCell = Nothing
	End If
End Function

Function CellName(oCell As Object) As String
	Dim aParts As Variant
	aParts = Split(oCell.AbsoluteName, ".")
	CellName = Replace(aParts(UBound(aParts)), "$", "") & " of " & oCell.Spreadsheet.Name
End Function

' ------------------------------------------------------------------ the dialog

Function Chosen(sTitle As String, sHint As String, bWritable As Boolean, ByRef sWhat As String) As Variant
	' The items that were chosen, none when somebody thought better of it. sWhat: which formulas, a letter each.
	Dim aPlaces As Variant, aItems() As String, n As Long, aBoxes As Variant
	OpenWizard(sTitle, sHint, bWritable)
	aBoxes = Array("I", "V", "U", "Q", "N", "T")
	Chosen = Array()
	If gDialog.execute() = 1 Then
		aPlaces = gDialog.getControl("Found").SelectedItemsPos
		If UBound(aPlaces) >= 0 Then
			ReDim aItems(UBound(aPlaces))
			For n = 0 To UBound(aPlaces)
				aItems(n) = gFound(aPlaces(n))
			Next n
			Chosen = aItems
		End If
		sWhat = ""
		If gDialog.getControl("Titles").State = 1 Then sWhat = "H"
		For n = 0 To UBound(aBoxes)
			If gDialog.getControl("What" & aBoxes(n)).State = 1 Then sWhat = sWhat & aBoxes(n)
		Next n
	End If
	gDialog.dispose()
End Function

Function OpenWizard(sTitle As String, sHint As String, bWritable As Boolean) As Variant
	' The dialog, filled but not shown; the lines of its list.
	Dim aBoxes As Variant, n As Long
	DialogLibraries.loadLibrary("Standard")
	gDialog = CreateUnoDialog(DialogLibraries.getByName("Standard").getByName("Wizard"))
	gDialog.Title = sTitle
	gWritable = bWritable
	gDialog.getControl("Hint").Text = sHint
	If bWritable Then
		aBoxes = Array("WhatI", "WhatV", "WhatU", "WhatQ", "WhatN", "WhatT", "Titles", "Columns")
		For n = 0 To UBound(aBoxes)
			gDialog.getControl(aBoxes(n)).Visible = False
		Next n
	End If
	WizardSearch()
	OpenWizard = gDialog.getControl("Found").Items
End Function

Sub WizardSearch
	' Fill the list; called at the beginning and by the button Search.
	Dim oList As Object, aLines As Variant, sWhy As String, nTotal As Long
	oList = gDialog.getControl("Found")
	oList.removeItems(0, oList.ItemCount)
	sWhy = FindItems(gDialog.getControl("Filter").Text, gWritable, gFound, aLines, nTotal)
	If sWhy <> "" Then
		gDialog.getControl("Count").Text = sWhy
		Exit Sub
	End If
	oList.addItems(aLines, 0)
	gDialog.getControl("Count").Text = nTotal & " items"
	If nTotal > MOST Then gDialog.getControl("Count").Text = "the first " & MOST & " of " & nTotal & " items; search for fewer"
End Sub

Function FindItems(sFilter As String, bWritable As Boolean, ByRef aItems As Variant, ByRef aLines As Variant, ByRef nTotal As Long) As String
	' Items of the gateway: IDs, lines for people, and how many there are. Empty, or what is wrong.
	Dim sPath As String, sJson As String, aParts As Variant, n As Long, nCount As Long, sOne As String
	Dim aFoundItems() As String, aFoundLines() As String
	sPath = "/api/items?samples=0&limit=" & MOST
	If sFilter <> "" Then sPath = sPath & "&filter=" & Encoded(sFilter)
	If bWritable Then sPath = sPath & "&writable=1"
	aItems = Array()
	aLines = Array()
	FindItems = HttpGet(sPath, sJson)
	If sJson = "" Then Exit Function
	nTotal = Val(Member(sJson, "total"))
	aParts = Split(sJson, "{""id"":")
	nCount = UBound(aParts)
	If nCount = 0 Then Exit Function
	ReDim aFoundItems(nCount - 1)
	ReDim aFoundLines(nCount - 1)
	For n = 1 To nCount
		sOne = "{""id"":" & aParts(n)
		aFoundItems(n - 1) = Member(sOne, "id")
		aFoundLines(n - 1) = Joined(Array(Member(sOne, "id"), Member(sOne, "type"), Member(sOne, "unit"), Member(sOne, "description")))
	Next n
	aItems = aFoundItems
	aLines = aFoundLines
End Function

Function Joined(aWords As Variant) As String
	Dim n As Long
	For n = 0 To UBound(aWords)
		If aWords(n) <> "" Then
			If n > 0 Then Joined = Joined & "   "
			Joined = Joined & aWords(n)
		End If
	Next n
End Function

' ------------------------------------------------------------------ what it makes

Function InsertFormulas(oAt As Object, aItems As Variant, sWhat As String) As String
	' A row for each item. sWhat: H titles above; I item, V value, U unit, Q quality code, N its name, T time stamp.
	Dim oSheet As Object, nRow As Long, nColumn As Long, n As Long, nLetter As Long, sLetters As String, oCell As Object
	Dim oFirst As Object
	oSheet = oAt.Spreadsheet
	nColumn = oAt.CellAddress.Column
	nRow = oAt.CellAddress.Row
	sLetters = Replace(sWhat, "H", "")
	If sLetters = "" Then sLetters = "V"
	oFirst = oSheet.getCellRangeByPosition(nColumn, nRow, nColumn + Len(sLetters) - 1, nRow + UBound(aItems) + Len(sWhat) - Len(sLetters))
	If Not IsBlank(oFirst) Then
		InsertFormulas = "There is something in " & CellName(oAt) & " or the cells below and beside it. Choose an empty place."
		Exit Function
	End If
	AddToSource(aItems)
	If Left(sWhat, 1) = "H" Then
		For nLetter = 1 To Len(sLetters)
			oCell = oSheet.getCellByPosition(nColumn + nLetter - 1, nRow)
			oCell.String = TitleOf(Mid(sLetters, nLetter, 1))
			oCell.CellStyle = "Title row"
			If Mid(sLetters, nLetter, 1) = "V" Then oCell.CellStyle = "Title row right"
		Next nLetter
		nRow = nRow + 1
	End If
	For n = 0 To UBound(aItems)
		For nLetter = 1 To Len(sLetters)
			PutFormula(oSheet.getCellByPosition(nColumn + nLetter - 1, nRow + n), aItems(n), Mid(sLetters, nLetter, 1))
		Next nLetter
	Next n
	InsertFormulas = ""
End Function

Function IsBlank(oRange As Object) As Boolean
	Dim aRows As Variant, nRow As Long, nColumn As Long
	aRows = oRange.getFormulaArray()
	For nRow = 0 To UBound(aRows)
		For nColumn = 0 To UBound(aRows(nRow))
			If aRows(nRow)(nColumn) <> "" Then Exit Function
		Next nColumn
	Next nRow
	IsBlank = True
End Function

Function TitleOf(sLetter As String) As String
	Select Case sLetter
		Case "I": TitleOf = "Item"
		Case "V": TitleOf = "Value"
		Case "U": TitleOf = "Unit"
		Case "Q": TitleOf = "Quality"
		Case "N": TitleOf = "Quality name"
		Case "T": TitleOf = "Time stamp"
	End Select
End Function

Sub PutFormula(oCell As Object, sItem As String, sLetter As String)
	Dim sKey As String, sJson As String
	sKey = """" & Replace(sItem, """", """""") & """"
	oCell.CellStyle = "Text"
	Select Case sLetter
		Case "I"
			oCell.String = sItem
		Case "V"
			oCell.Formula = "=IFNA(VLOOKUP(" & sKey & ";PCA_LIVE;2;0);IFNA(VLOOKUP(" & sKey & ";PCA_LAST;2;0);""""))"
			oCell.CellStyle = "Value"
		Case "U"
			HttpGet("/api/items/" & Encoded(sItem), sJson)
			oCell.String = Member(sJson, "unit")
		Case "Q"
			oCell.Formula = "=IFNA(VLOOKUP(" & sKey & ";PCA_LIVE;3;0);PCA_MISSING)"
			oCell.CellStyle = "Code"
		Case "N"
			oCell.Formula = "=IFNA(VLOOKUP(" & sKey & ";PCA_LIVE;4;0);PCA_MISSING_NAME)"
		Case "T"
			oCell.Formula = "=IFNA(VLOOKUP(" & sKey & ";PCA_LIVE;5;0);IFNA(VLOOKUP(" & sKey & ";PCA_LAST;5;0);""""))"
			oCell.CellStyle = "Time stamp"
	End Select
End Sub

Function AddWriteRows(aItems As Variant) As String
	' Below the rows that are there; an item that has a row does not get another.
	Dim oSheet As Object, n As Long, nRow As Long, sJson As String, sWhy As String, sLow As String, sHigh As String
	Dim aReadable() As String, nReadable As Long
	oSheet = ThisComponent.Sheets.getByName(WRITE_SHEET)
	For n = 0 To UBound(aItems)
		If WriteRow(oSheet, aItems(n)) < 0 Then
			sWhy = HttpGet("/api/items/" & Encoded(aItems(n)), sJson)
			If sWhy <> "" Then
				AddWriteRows = aItems(n) & ": " & sWhy
				Exit Function
			End If
			nRow = NextWriteRow(oSheet)
			oSheet.getCellByPosition(ITEM, nRow).String = Member(sJson, "id")
			PutFormula(oSheet.getCellByPosition(1, nRow), Member(sJson, "id"), "V")
			oSheet.getCellByPosition(NEW_VALUE, nRow).CellStyle = "Write cell"
			oSheet.getCellByPosition(4, nRow).String = Member(sJson, "type")
			sLow = Member(sJson, "low")
			sHigh = Member(sJson, "high")
			If sLow & sHigh <> "" Then oSheet.getCellByPosition(5, nRow).String = sLow & " to " & sHigh
			oSheet.getCellByPosition(6, nRow).String = Member(sJson, "unit")
			oSheet.getCellByPosition(7, nRow).String = Member(sJson, "description")
			If InStr(Member(sJson, "access"), "R") > 0 Then
				ReDim Preserve aReadable(nReadable)
				aReadable(nReadable) = Member(sJson, "id")
				nReadable = nReadable + 1
			End If
		End If
	Next n
	If nReadable > 0 Then AddToSource(aReadable)
	AddWriteRows = ""
End Function

Function WriteRow(oSheet As Object, sItem As String) As Long
	Dim nRow As Long
	For nRow = FIRST_ROW To UsedRows(oSheet) - 1
		If LCase(oSheet.getCellByPosition(ITEM, nRow).String) = LCase(sItem) Then
			WriteRow = nRow
			Exit Function
		End If
	Next nRow
	WriteRow = -1
End Function

Function NextWriteRow(oSheet As Object) As Long
	' The one below the last that has an item.
	Dim nRow As Long
	NextWriteRow = FIRST_ROW
	For nRow = FIRST_ROW To UsedRows(oSheet) - 1
		If oSheet.getCellByPosition(ITEM, nRow).String <> "" Then NextWriteRow = nRow + 1
	Next nRow
End Function
